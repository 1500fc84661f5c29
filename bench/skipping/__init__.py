"""Skipping: what each stage leaves out, what that saves, and how other libraries' broad phases do."""
