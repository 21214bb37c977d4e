// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/load_rig.hpp"
#include "tests/rigs/example_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <ostream>
#include <string>

namespace twang::test {

/// One fault put into the example rig: the message must begin with file, line and key and hold
/// `said`.
struct Fault {
  const char* name;
  const char* sound;   ///< text of the example, found there once
  const char* faulty;  ///< what stands there instead
  const char* place;   ///< the line of the faulty file that is complained of begins with this
  const char* key;
  const char* said;
};

inline void PrintTo(const Fault& fault, std::ostream* stream) { *stream << fault.name; }

inline std::string name_of(const ::testing::TestParamInfo<Fault>& info) { return info.param.name; }

inline void expect_refused(const Fault& fault) {
  const std::string text = example_with(fault.sound, fault.faulty);
  ASSERT_FALSE(text.empty()) << "the example must hold exactly once: " << fault.sound;
  ASSERT_NE(text.find(fault.place), std::string::npos) << fault.place;
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("rig.toml", text);
  const std::string message = refusal_of([&] { (void)load_rig(path); });
  const std::string place = path.string() + ":" + std::to_string(line_of(text, fault.place));
  EXPECT_TRUE(message.starts_with(place + ": " + fault.key + " "))
      << message << "\nmust begin with\n"
      << place << ": " << fault.key;
  EXPECT_TRUE(holds(message, fault.said));
  EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line";
}

}  // namespace twang::test
