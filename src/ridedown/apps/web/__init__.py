"""The live page: a server that parses, calls and answers, and a small front end that shows. No physics."""
