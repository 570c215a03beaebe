/// The command line tool, without its main().
#ifndef RIG_TOOL_H
#define RIG_TOOL_H

/// Returns the exit code.
int tool_main(int argc, char **argv);

#endif
