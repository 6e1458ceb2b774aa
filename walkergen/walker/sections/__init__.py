"""Cross-sections of legs, a file each: what follows from a leg's kind (see `limbs.CrossSection`)."""
