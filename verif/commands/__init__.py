"""Commands of the environment and its methods: nothing of it imports them."""
