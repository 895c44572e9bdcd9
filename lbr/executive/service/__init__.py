"""The executive's services for people and programs: lines and answers, stops, reports, edits, the journal."""
