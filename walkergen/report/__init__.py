"""What people look at: tables, figures, previews."""
