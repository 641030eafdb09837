// Entry points in libFuzzer's form: clang++ -fsanitize=fuzzer fuzz_X.cpp takes them as they are. In the short tier
// fuzz_test.cpp calls them under the names fuzz_X (the build renames them) with seeded mutations of good input.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
