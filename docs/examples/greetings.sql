-- Rows for the table of greetings.py, which `lbr db table greetings` makes, and those that have it run.
PRAGMA foreign_keys = ON;
BEGIN;
INSERT INTO greeting (robot, name, text) VALUES ('lbr', 'ann', 'Good day, Ann.'), ('lbr', 'bob', 'Hello Bob!');
INSERT INTO capability (robot, name, kind, help) VALUES ('lbr', 'greetings', 'greetings', 'Greets people by name');
INSERT INTO verb (robot, word, pattern, target, help)
VALUES ('lbr', 'greet', '/greet/{name}', 'greetings.greet', 'Greet a person by name');
COMMIT;
