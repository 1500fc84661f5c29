"""The functional coverage model, its merging and its reports."""
