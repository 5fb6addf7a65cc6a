"""The section of duets: a leader and who answers, offline and live, and the recorded answer for comparison."""
