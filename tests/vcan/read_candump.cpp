// Reads candump -L text from standard input and writes it again: what our reader understood. Exit 1 at a line it
// refuses.
#include <cstdio>
#include <iostream>
#include <string>

#include "protocol/candump.hpp"

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    const armsight::CandumpResult read = armsight::parse_candump(line);
    if (!read.line) {
      std::fprintf(stderr, "read_candump: %s: %s\n", line.c_str(), read.why.c_str());
      return 1;
    }
    std::printf("%s\n", armsight::to_candump(*read.line).c_str());
  }
  return 0;
}
