// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/unseen_markers.hpp"

#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace twang::test {
namespace {

/// Tip, so many fixed ones, and another moving one.
Rig strip_with_middle(int num_fixed) {
  Rig rig = strip_rig(num_fixed);
  Marker middle = rig.markers[0];
  middle.id = "middle";
  middle.position.x() = 40e-3;
  rig.markers.push_back(middle);
  return rig;
}

std::vector<Note> judge(const Rig& rig, const std::vector<bool>& seen) {
  return detail::judge_unseen_markers(rig, seen, "film.mp4", 60);
}

TEST(UnseenMarkers, AreWarnedOfWhereNothingNeedsThem) {
  const Rig rig = strip_with_middle(4);
  EXPECT_TRUE(judge(rig, {true, true, true, true, true, true}).empty());
  const std::vector<Note> moving = judge(rig, {true, true, true, true, true, false});
  ASSERT_EQ(moving.size(), 1U);
  EXPECT_EQ(moving[0].severity, Severity::Warning);
  EXPECT_EQ(moving[0].text,
            "Marker 'middle' was not found in any of 60 frames: its columns are nan.");
  const std::vector<Note> both = judge(rig, {true, true, false, true, true, false});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_TRUE(holds(both[0].text, "Marker 'bench_2' was not found in any of 60 frames"));
  EXPECT_TRUE(holds(both[0].text, "come from 3 fixed markers instead of 4"));
}

TEST(UnseenMarkers, AreRefusedWhereTheObservableNeedsThem) {
  Rig rig = strip_with_middle(4);
  const std::vector<bool> no_tip = {false, true, true, true, true, true};
  EXPECT_EQ(refusal_of([&] { (void)judge(rig, no_tip); }),
            "film.mp4: marker 'tip' was not found in any of 60 frames and is needed for the "
            "observable, must be a cross of 5 mm in plain view; give --marker tip=x,y");
  rig.observable.reset();
  EXPECT_EQ(judge(rig, no_tip).size(), 1U);
  EXPECT_TRUE(holds(refusal_of([&] {
                      (void)judge(rig, {false, true, true, true, true, false});
                    }),
                    "needed for the motion"));
}

TEST(UnseenMarkers, AreRefusedWhereTheScaleNeedsThem) {
  const std::string needed = "needed for the scale, must be a dot of 6 mm";
  const Rig four = strip_with_middle(4);
  EXPECT_EQ(judge(four, {true, true, false, false, true, true}).size(), 2U);
  EXPECT_TRUE(holds(refusal_of([&] {
                      (void)judge(four, {true, true, false, false, false, true});
                    }),
                    needed));
  const Rig two = strip_with_middle(2);
  EXPECT_TRUE(holds(refusal_of([&] { (void)judge(two, {true, true, false, true}); }), needed));
  const Rig one = strip_with_middle(1);
  EXPECT_TRUE(holds(refusal_of([&] { (void)judge(one, {true, false, true}); }), needed));
  const Rig none = strip_with_middle(0);
  EXPECT_TRUE(holds(refusal_of([&] {
                      (void)judge(none, {true, false});
                    }),
                    "'middle' was not found"));
}

}  // namespace
}  // namespace twang::test
