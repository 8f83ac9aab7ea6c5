"""Reference pages made from the program itself: tables of parameters, commands, keys, columns and texts."""
