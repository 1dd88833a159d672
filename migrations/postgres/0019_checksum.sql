-- SHA-256 of a document's text, so that an altered one is noticed: server/store/result.rs. Null beside what was stored before.
ALTER TABLE result ADD COLUMN sha256 TEXT;
