// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "core/trace_file.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

void require(bool true_of_every_trace) {
  if (!true_of_every_trace) std::abort();
}

/// What the reader promises of a trace that it accepts.
void check(const twang::Trace& trace) {
  require(!trace.time_s.empty());
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    require(std::isfinite(trace.time_s[i]));
    require(i == 0 || trace.time_s[i] > trace.time_s[i - 1]);
  }
  for (const twang::Channel& channel : trace.channels) {
    require(channel.values.size() == trace.time_s.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    check(twang::parse_trace_csv({reinterpret_cast<const char*>(data), size}, "fuzz.csv"));
  } catch (const twang::InputError& error) {
    require(std::string(error.what()).find("fuzz.csv") != std::string::npos);
  }
  return 0;
}
