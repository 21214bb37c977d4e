// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

namespace twang {
namespace {

/// What a shell command writes to standard output.
std::string output_of(const std::string& command) {
  std::string out;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  std::array<char, 4096> part{};
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    out.append(part.data(), n);
  pclose(pipe);
  return out;
}

TEST(StartUp, LoadsNoCodecBeforeThereIsAFilm) {
  // With this variable the loader lists the libraries instead of running the program.
  const std::string libraries =
      output_of("LD_TRACE_LOADED_OBJECTS=1 '" + std::string(TWANG_EXECUTABLE) + "'");
  EXPECT_NE(libraries.find("libopencv_core"), std::string::npos) << libraries;
  EXPECT_EQ(libraries.find("libav"), std::string::npos) << libraries;
}

}  // namespace
}  // namespace twang
