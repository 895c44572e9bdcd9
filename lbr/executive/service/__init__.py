"""What people and programs have of the executive: lines and answers, stops, reports, edits, the journal."""
