// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/trace_file.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "tests/support/real_recordings.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace twang {
namespace {

/// Eighteen coordinates of six markers: three on the beam, three on the frame, of which one is set
/// down while the beam is still held.
void expect_joint_as_alone(const std::string& file, double within_hz, double within_per_s) {
  const auto path = test::real_recordings() / "silicone_beam" / file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recording at " << path.string();
  const Trace trace = read_trace_csv(path);
  const InversionResult alone = invert_harmonics(trace, {"m0x_m"});
  const InversionResult joint = invert_harmonics(trace, default_columns(trace));
  ASSERT_EQ(joint.channel_names.size(), 18U);
  ASSERT_TRUE(alone.usable() && joint.usable()) << alone.message << "\n" << joint.message;
  EXPECT_NEAR(joint.time_origin_s, alone.time_origin_s, 0.02);  // two samples
  EXPECT_NEAR(joint.modes[0].frequency_hz, alone.modes[0].frequency_hz, within_hz);
  EXPECT_NEAR(joint.modes[0].decay_per_s, alone.modes[0].decay_per_s, within_per_s);
}

TEST(SiliconeBeam, AllMarkersTogetherSwayAsOneAlone) {
  // Of the sideways bending near 8.2 Hz, and of a mode that is a few percent faster and more damped
  // when small, the channels hold different parts.
  expect_joint_as_alone("beam_gravity_V2_a.csv", 0.02, 0.4);
  expect_joint_as_alone("beam_gravity_V2_b.csv", 0.02, 0.4);
  expect_joint_as_alone("beam_load52_V2_a.csv", 0.01, 0.1);
}

}  // namespace
}  // namespace twang
