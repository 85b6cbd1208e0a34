"""What the service keeps: tables, their migrations, and the one way to write them."""
