// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/assign_markers.hpp"

#include "capture/detail/companions.hpp"
#include "capture/detail/forecast.hpp"
#include "capture/detail/layout_map.hpp"
#include "capture/detail/lost_stretches.hpp"
#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace twang::detail {
namespace {

/// The least cost over all one-to-one assignments, by trying them all.
double least_cost(const Eigen::MatrixXd& cost,
                  double missing,
                  Eigen::Index row,
                  std::vector<bool>& taken) {
  if (row == cost.rows()) return 0.0;
  double least = missing + least_cost(cost, missing, row + 1, taken);
  for (Eigen::Index p = 0; p < cost.cols(); ++p) {
    if (taken[static_cast<std::size_t>(p)] || !std::isfinite(cost(row, p))) continue;
    taken[static_cast<std::size_t>(p)] = true;
    least = std::min(least, cost(row, p) + least_cost(cost, missing, row + 1, taken));
    taken[static_cast<std::size_t>(p)] = false;
  }
  return least;
}

double least_cost(const Eigen::MatrixXd& cost, double missing) {
  std::vector<bool> taken(static_cast<std::size_t>(cost.cols()), false);
  return least_cost(cost, missing, 0, taken);
}

TEST(AssignMarkers, IsTheCheapestOfAllAssignments) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> price(-5.0, 30.0);
  std::uniform_int_distribution<int> size(1, 5);
  for (int draw = 0; draw < 300; ++draw) {
    Eigen::MatrixXd cost(size(random), size(random) - 1);
    for (Eigen::Index k = 0; k < cost.size(); ++k) {
      const double drawn = price(random);
      cost.data()[k] = drawn > 22.0 ? kInfinity : drawn;
    }
    const Assignment found = assign_markers_with_margins(cost, 12.0);
    EXPECT_NEAR(found.cost, least_cost(cost, 12.0), 1e-6) << cost;  // sums of a few prices
    for (std::size_t i = 0; i < found.place.size(); ++i) {
      if (found.place[i] < 0) continue;
      Eigen::MatrixXd without = cost;
      without(static_cast<Eigen::Index>(i), found.place[i]) = kInfinity;
      EXPECT_NEAR(found.margin[i], least_cost(without, 12.0) - found.cost, 1e-6) << cost;
    }
  }
}

TEST(AssignMarkers, EqualClaimsHaveNoMargin) {
  Eigen::MatrixXd cost(2, 1);
  cost << 3.0, 3.0;
  const Assignment found = assign_markers_with_margins(cost, 40.0);
  EXPECT_EQ(std::count(found.place.begin(), found.place.end(), 0), 1);
  for (std::size_t i = 0; i < 2; ++i) {
    if (found.place[i] == 0) {
      EXPECT_NEAR(found.margin[i], 0.0, 1e-9);
    }
  }
}

constexpr double kStep = 0.9;  // phase from frame to frame [rad]: seven frames a period

Eigen::Vector2d damped(int n) {
  return Eigen::Vector2d(40.0, -9.0) * std::exp(-0.05 * n) * std::cos(kStep * n) +
         Eigen::Vector2d(100.0, 60.0);
}

TEST(MotionForecast, LearnsADampedVibrationAboutAnyMiddle) {
  // The rest it was told is five pixels off.
  MotionForecast forecast({104.0, 63.0}, damped(0), 12.0);
  for (int n = 1; n < 16; ++n) forecast.found(damped(n));
  // An exact recurrence, but for what holds it where the places say nothing: some tenths of the
  // amplitude's hundredth.
  EXPECT_LT((forecast.next().px - damped(16)).norm(), 0.5);
  EXPECT_LT(forecast.next().sigma_px, 3.0);
}

TEST(MotionForecast, RunsOnWhileTheMarkerIsLostAndSaysHowUncertain) {
  MotionForecast forecast({100.0, 60.0}, damped(0), 12.0);
  for (int n = 1; n < 20; ++n) forecast.found(damped(n));
  double last_sigma = forecast.next().sigma_px;
  for (int n = 20; n < 27; ++n) {  // a whole period
    EXPECT_LT((forecast.next().px - damped(n)).norm(), 3.0 * forecast.next().sigma_px) << n;
    EXPECT_LT((forecast.next().px - damped(n)).norm(), 4.0) << n;  // it moves 30 px a frame
    forecast.lost();
    EXPECT_GT(forecast.next().sigma_px, last_sigma);
    last_sigma = forecast.next().sigma_px;
  }
  EXPECT_EQ(forecast.frames_lost(), 7);
  forecast.found(damped(27));
  EXPECT_EQ(forecast.frames_lost(), 0);
}

TEST(Companions, TellWhereAMarkerWentWithTheOthers) {
  // The second goes 1.4 times as far and a quarter turn further on, about another middle.
  Companions companions(2);
  const auto first = [](int n) { return Eigen::Vector2d(8.0 * std::cos(0.7 * n), 3.0); };
  const auto second = [&](int n) { return Eigen::Vector2d(-1.0, 2.0 + 1.4 * first(n).x()); };
  for (int n = 0; n < 20; ++n) companions.add({first(n), second(n)});
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(kNaN);
  const auto told = companions.predict(1, {first(23), nowhere});
  ASSERT_TRUE(told.has_value());
  EXPECT_LT((told->px - second(23)).norm(), 1e-6);  // exact relation
  EXPECT_LT(told->sigma_px, 1.0);
  EXPECT_FALSE(companions.predict(1, {nowhere, nowhere}).has_value());
}

TEST(Companions, ThatStandStillTellNothing) {
  Companions companions(2);
  for (int n = 0; n < 20; ++n) companions.add({{30.0, 0.0}, {20.0 + 5.0 * std::cos(n), 0.0}});
  EXPECT_FALSE(companions.predict(1, {{0.0, 0.0}, {kNaN, kNaN}}).has_value());
}

TEST(Companions, ContradictByAMajorityOfTwo) {
  Companions companions(4);
  const auto at = [](int n, double share) {
    return Eigen::Vector2d(share * std::sin(0.8 * n), 0.0);
  };
  for (int n = 0; n < 20; ++n) companions.add({at(n, 10), at(n, 20), at(n, 30), at(n, 40)});
  std::vector<Eigen::Vector2d> now = {at(21, 10), at(21, 20), at(21, 30), at(21, 40)};
  EXPECT_FALSE(companions.contradict(3, now, 3.0, 8.0));
  now[3].x() += 30.0;
  EXPECT_TRUE(companions.contradict(3, now, 3.0, 8.0));
  EXPECT_FALSE(companions.contradict(0, now, 3.0, 8.0));  // one against two
  now[0] = now[1] = Eigen::Vector2d::Constant(kNaN);
  EXPECT_FALSE(companions.contradict(3, now, 3.0, 8.0));  // one against none: either may be wrong
}

TEST(LayoutMap, FollowsSlantAndPerspective) {
  Homography truth;
  truth << 9.0, 0.6, 300.0, -0.4, 8.2, 200.0, 4e-4, -2e-4, 1.0;
  std::vector<LayoutPair> pairs;
  for (const double x : {-40.0, 5.0, 38.0}) {
    for (const double y : {-25.0, 3.0, 24.0}) {
      pairs.push_back({{x, y}, map_point(truth, {x, y}), 0.3});
    }
  }
  const Homography found = fit_layout_map(pairs, 94.0);
  // What holds it to a similarity weighs a thousandth of what the pairs say.
  for (const LayoutPair& pair : pairs)
    EXPECT_LT((map_point(found, pair.plane) - pair.px).norm(), 0.1);
}

TEST(LayoutMap, OfMarkersOnALineIsASimilarity) {
  std::vector<LayoutPair> pairs;
  for (const double x : {-3.0, -1.0, 2.0, 4.0})
    pairs.push_back({{x, 0.0}, {50.0 + 10.0 * x, 70.0}, 0.3});
  const Homography found = fit_layout_map(pairs, 7.0);
  EXPECT_LT((map_point(found, {0.0, 5.0}) - Eigen::Vector2d(50.0, 120.0)).norm(), 1e-6);
}

TEST(LostStretches, AreGatheredFromFramesInARow) {
  MarkerTrack track{"tip", {}, {}, 0, "", {}};
  for (const std::size_t n : {30U, 31U, 32U, 40U}) note_lost(track, n, n < 40 ? "first" : "second");
  ASSERT_EQ(track.lost.size(), 2U);
  EXPECT_EQ(track.lost[0].first_frame, 30U);
  EXPECT_EQ(track.lost[0].num_frames, 3U);
  EXPECT_EQ(track.lost[1].reason, "second");
  EXPECT_EQ(track.frames_lost, 4);
  EXPECT_EQ(track.lost_because, "first");
}

TEST(LostStretches, AreToldInAFewSentencesAndACount) {
  MarkerTrack track{"tip", {}, {}, 0, "", {}};
  for (std::size_t k = 0; k < 6; ++k) {
    note_lost(track, 30 + 10 * k, "it is hidden");
    note_lost(track, 31 + 10 * k, "it is hidden");
    track.lost.back().found_again = k < 5;
  }
  const auto sentences = notes_on_losses(track);
  ASSERT_EQ(sentences.size(), 4U);
  EXPECT_EQ(sentences[0].text,
            "Marker 'tip' was lost in frames 30-31 (it is hidden) and found again in frame 32.");
  EXPECT_EQ(sentences[3].text, "Marker 'tip' was lost 3 times more, in 6 frames.");
  EXPECT_EQ(sentences[0].severity, Severity::Remark);
  EXPECT_EQ(sentences[3].severity, Severity::Warning);
  track.lost = {{40, 20, "it is hidden", false}};
  EXPECT_EQ(notes_on_losses(track).at(0).text,
            "Marker 'tip' was lost in frames 40-59 (it is hidden) and not found again.");
  EXPECT_EQ(notes_on_losses(track).at(0).severity, Severity::Warning);
  EXPECT_TRUE(notes_on_losses({"tip", {}, {}, 0, "", {}}).empty());
}

}  // namespace
}  // namespace twang::detail
