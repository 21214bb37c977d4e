// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/releases.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"
#include "tests/support/real_recordings.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <random>

namespace twang {
namespace {

/// Pulled slowly, held and let go, again and again.
struct PulledAndReleased {
  std::vector<double> pulls = {4.0, 6.0, 5.0};  // [mm]
  std::vector<double> frequencies_hz = {12.0, 12.0, 12.0};
  double decay_per_s = 3.0;
  double pull_s = 0.6;
  double hold_s = 0.3;
  double free_s = 2.1;
  double noise = 0.02;

  [[nodiscard]] double cycle_s() const { return pull_s + hold_s + free_s; }
  [[nodiscard]] double release_s(std::size_t n) const {
    return static_cast<double>(n) * cycle_s() + pull_s + hold_s;
  }
  [[nodiscard]] Trace film() const {
    std::mt19937 random(4);
    std::normal_distribution<double> error(0.0, noise);
    Trace trace;
    Channel channel{"y_mm", {}};
    const double end_s = cycle_s() * static_cast<double>(pulls.size());
    for (int i = 0; i / kRate_hz < end_s; ++i) {
      const double t = i / kRate_hz;
      const auto n = static_cast<std::size_t>(t / cycle_s());
      const double s = t - static_cast<double>(n) * cycle_s();
      double y = 0.0;
      if (s < pull_s) {
        y = pulls[n] * 0.5 * (1.0 - std::cos(kPi * s / pull_s));
      } else if (s < pull_s + hold_s) {
        y = pulls[n];
      } else {
        const double u = s - pull_s - hold_s;
        y = pulls[n] * std::exp(-decay_per_s * u) * std::cos(kTwoPi * frequencies_hz[n] * u);
      }
      trace.time_s.push_back(t);
      channel.values.push_back(y + error(random));
    }
    trace.channels.push_back(std::move(channel));
    return trace;
  }
};

TEST(Releases, OfARecordAreFoundAndEachHoldsOne) {
  const PulledAndReleased pulled;
  const std::vector<Trace> parts = cut_at_releases(pulled.film(), {"y_mm"});
  ASSERT_EQ(parts.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_LT(parts[n].time_s.front(), pulled.release_s(n));
    EXPECT_GT(parts[n].time_s.back(), pulled.release_s(n) + 0.5 * pulled.free_s);
    // The next pull has not gone far: a tenth of it.
    EXPECT_LT(parts[n].time_s.back(), pulled.release_s(n) + pulled.free_s + 0.2 * pulled.pull_s);
    ASSERT_EQ(parts[n].channels.size(), 1U);
    EXPECT_EQ(parts[n].channels[0].values.size(), parts[n].time_s.size());
  }
}

TEST(Releases, TogetherAndAloneGiveTheTruth) {
  const PulledAndReleased pulled;
  const RepeatedInversion repeated =
      compare_repeats(cut_at_releases(pulled.film(), {"y_mm"}), {"y_mm"});
  ASSERT_EQ(repeated.joint.modes.size(), 1U) << repeated.joint.message;
  const DampedSinusoid& mode = repeated.joint.modes[0];
  EXPECT_NEAR(mode.frequency_hz, 12.0, 4.0 * mode.frequency_sigma_hz);
  EXPECT_NEAR(mode.decay_per_s, 3.0, 4.0 * mode.decay_sigma_per_s);
  ASSERT_EQ(repeated.alone.size(), 3U);
  double squares = 0.0;
  for (std::size_t n = 0; n < 3; ++n) {
    const DampedSinusoid* alone = repeated.mode_alone(n);
    ASSERT_NE(alone, nullptr);
    ASSERT_TRUE(repeated.alone[n].release_s.has_value());
    EXPECT_NEAR(*repeated.alone[n].release_s, pulled.release_s(n), 0.02);
    EXPECT_NEAR(alone->frequency_hz, 12.0, 4.0 * alone->frequency_sigma_hz);
    squares += alone->frequency_sigma_hz * alone->frequency_sigma_hz / 3.0;
  }
  // Nothing but noise differs: the scatter of three is within a factor 3 of their sigmas.
  EXPECT_LT(repeated.frequency_scatter_hz, 3.0 * std::sqrt(squares));
  EXPECT_GT(repeated.frequency_scatter_hz, 0.05 * std::sqrt(squares));
}

TEST(Releases, ThatDifferShowInTheScatter) {
  PulledAndReleased pulled;
  pulled.frequencies_hz = {12.0, 12.2, 11.8};
  const RepeatedInversion repeated =
      compare_repeats(cut_at_releases(pulled.film(), {"y_mm"}), {"y_mm"});
  EXPECT_NEAR(repeated.frequency_scatter_hz, 0.2, 0.02);  // of 12.0, 12.2, 11.8
  const auto json = nlohmann::json::parse(modes_to_json(repeated));
  EXPECT_EQ(json.at("format"), "twang-modes/1");
  ASSERT_EQ(json.at("repeats").size(), 3U);
  EXPECT_NEAR(json.at("repeats").at(1).at("frequency_hz").get<double>(), 12.2, 0.01);
  EXPECT_NEAR(json.at("repeats").at(1).at("release_s").get<double>(), pulled.release_s(1), 0.02);
  EXPECT_EQ(json.at("repeat_scatter").at("frequency_hz"), repeated.frequency_scatter_hz);
  EXPECT_TRUE(json.at("modes").at(0).contains("frequency_hz"));
}

TEST(Releases, OnlyThoseAfterTheStartAreTaken) {
  const PulledAndReleased pulled;
  InversionOptions options;
  options.start_s = pulled.cycle_s();
  const std::vector<Trace> parts = cut_at_releases(pulled.film(), {"y_mm"}, options);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_GE(parts[0].time_s.front(), pulled.cycle_s());
}

TEST(Releases, ARecordInFreeMotionIsOnePart) {
  PulledAndReleased pulled;
  pulled.pulls = {4.0};
  Trace trace = pulled.film();
  const auto free = static_cast<std::ptrdiff_t>(kRate_hz * (pulled.release_s(0) + 0.01));
  trace.time_s.erase(trace.time_s.begin(), trace.time_s.begin() + free);
  trace.channels[0].values.erase(trace.channels[0].values.begin(),
                                 trace.channels[0].values.begin() + free);
  const std::vector<Trace> parts = cut_at_releases(trace, {"y_mm"});
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].time_s, trace.time_s);
}

TEST(Releases, StartBehindTheRecordIsRefused) {
  InversionOptions options;
  options.start_s = 100.0;
  EXPECT_THROW((void)cut_at_releases(PulledAndReleased{}.film(), {"y_mm"}, options), InputError);
}

TEST(Releases, UnknownColumnIsRefused) {
  EXPECT_THROW((void)cut_at_releases(PulledAndReleased{}.film(), {"x_mm"}), InputError);
}

/// Six fits by others: 6.97 +- 0.05 Hz, damping ratio 0.086 +- 0.005, stiffer at small amplitude,
/// released near these frames, at 22.674 frames/s.
TEST(KnexTower, SixReleasesAreFoundAndSayThatFrequencyDependsOnAmplitude) {
  const auto path = test::real_recordings() / "knex_tower" / "tower_rows_px.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recording at " << path.string();
  const Trace trace = read_trace_csv(path, "t_s");
  const std::vector<std::string> rows = {"storey1_dx_px", "storey2_dx_px"};
  const RepeatedInversion repeated = compare_repeats(cut_at_releases(trace, rows), rows);
  for (const double frame : {147.0, 228.0, 305.0, 377.0, 452.0, 524.0}) {
    double nearest = kInfinity;
    for (const InversionResult& alone : repeated.alone) {
      ASSERT_TRUE(alone.release_s.has_value());
      nearest = std::min(nearest, std::abs(*alone.release_s * 22.674 - frame));
    }
    EXPECT_LE(nearest, 3.0) << frame;  // the pull ends and the thread lets go within so many
  }
  EXPECT_EQ(repeated.alone.size(), 7U);  // those six, and a first pull that was smaller
  ASSERT_FALSE(repeated.joint.modes.empty()) << repeated.joint.message;
  EXPECT_NEAR(repeated.joint.modes[0].frequency_hz, 6.97, 0.1);
  EXPECT_NEAR(repeated.joint.modes[0].damping_ratio(), 0.086, 0.01);
  const auto& notes = repeated.joint.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("it softens with amplitude") != std::string::npos;
  }));
}

}  // namespace
}  // namespace twang
