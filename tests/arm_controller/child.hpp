// Runs a piece of a test in a process of its own, whose rights and threads it may spoil.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

namespace armsight::arm::test {

struct ChildEnd {
  int exit_code = -1;  ///< -1: it was killed
  int signal = 0;
};

/// `work` answers the exit code.
template <typename Work>
ChildEnd run_in_child(Work&& work) {
  const pid_t pid = ::fork();
  if (pid == 0) ::_exit(work());
  int status = 0;
  ::waitpid(pid, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, WIFSIGNALED(status) ? WTERMSIG(status) : 0};
}

}  // namespace armsight::arm::test
