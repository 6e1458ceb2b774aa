"""Films of printed walkers: from frames to tracks (`film`), and from tracks to measured motion (`analyse`)."""
