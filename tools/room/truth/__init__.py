"""What is true of a room and of a recording of it, and questions with their exact answers."""
