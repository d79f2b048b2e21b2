"""From a question to an answer, with calibrated confidence."""
