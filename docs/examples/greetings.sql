-- The table of greetings.py, with the triggers that keep its changes; then the rows that have it run.
PRAGMA foreign_keys = ON;
BEGIN;
CREATE TABLE greeting (
    robot TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    name  TEXT    NOT NULL,
    text  TEXT    NOT NULL CHECK (length(text) BETWEEN 1 AND 200),
    said  INTEGER NOT NULL DEFAULT 0 CHECK (said BETWEEN 0 AND 1000000),
    PRIMARY KEY (robot, name)
) STRICT;
CREATE TRIGGER greeting_insert AFTER INSERT ON greeting BEGIN
    INSERT INTO revision (table_name, row_key, operation, new_row)
    VALUES ('greeting', json_array(NEW.robot, NEW.name), 'insert', json_object('text', NEW.text, 'said', NEW.said));
END;
CREATE TRIGGER greeting_update AFTER UPDATE ON greeting BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('greeting', json_array(NEW.robot, NEW.name), 'update',
            json_object('text', OLD.text, 'said', OLD.said), json_object('text', NEW.text, 'said', NEW.said));
END;
CREATE TRIGGER greeting_delete AFTER DELETE ON greeting BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row)
    VALUES ('greeting', json_array(OLD.robot, OLD.name), 'delete', json_object('text', OLD.text, 'said', OLD.said));
END;
INSERT INTO greeting (robot, name, text) VALUES ('lbr', 'ann', 'Good day, Ann.'), ('lbr', 'bob', 'Hello Bob!');
INSERT INTO capability (robot, name, kind, help) VALUES ('lbr', 'greetings', 'greetings', 'Greets people by name');
INSERT INTO verb (robot, word, pattern, target, help)
VALUES ('lbr', 'greet', '/greet/{name}', 'greetings.greet', 'Greet a person by name');
COMMIT;
