"""Hard cases: exact outcomes and invariants that must hold on any machine (`case.Case`)."""
