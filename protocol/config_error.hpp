// Bad input from people: a file, a flag, a key.
#pragma once

#include <stdexcept>

namespace armsight {

/// what() holds one violation a line. Caught once in main: exit code 2.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace armsight
