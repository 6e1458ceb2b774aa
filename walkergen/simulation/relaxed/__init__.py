"""Model A: rigid motion on relaxed legs, from event to event; the braced walker as well."""
