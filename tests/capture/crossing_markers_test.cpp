// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"
#include "tests/capture/filmed_crossing.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

namespace twang::test {
namespace {

/// Two dots that look alike, on paths that lie `beside` diameters apart.
struct Crossing {
  const char* name;
  double rest_a_mm, rest_b_mm;  ///< along the paths
  double beside;                ///< of the paths, in diameters
  Swing a, b;
  unsigned seed;
};

std::ostream& operator<<(std::ostream& out, const Crossing& crossing) {
  return out << crossing.name;
}

Swing across(double amplitude_mm,
             double frequency_hz,
             double decay_per_s = 2.0,
             double phase_rad = 0.0,
             double release_s = 0.0) {
  return {{amplitude_mm, 0.0}, frequency_hz, decay_per_s, release_s, phase_rad};
}

class CrossingMarkers : public ::testing::TestWithParam<Crossing> {
 protected:
  TemporaryFolder m_folder;
};

TEST_P(CrossingMarkers, AreNeverTakenForEachOther) {
  const Crossing& crossing = GetParam();
  constexpr double kSize_mm = 4.0;
  Rig rig = dotted_bench();
  const bool passes_fixed = crossing.b.frequency_hz == 0.0;
  rig.markers.insert(
      rig.markers.begin(),
      {dot("a", crossing.rest_a_mm, 2.0, false),
       dot("b", crossing.rest_b_mm, 2.0 - crossing.beside * kSize_mm, passes_fixed)});
  FilmOptions options;
  options.width_px = 480;
  options.height_px = 270;
  options.duration_s = 0.6;
  options.seed = crossing.seed;
  const auto path = m_folder.path() / "film.mkv";
  const FilmTruth truth = render_film(
      rig,
      [&](double time_s) {
        return swinging(rig, {crossing.a, crossing.b}, time_s);
      },
      path,
      options);
  const TrackResult result = track_markers(rig, path);
  const double size_px = kSize_mm / truth.mm_per_px;
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Fidelity got = fidelity(result.tracks[i], truth.position_px, i, [&](std::size_t n) {
      return nearest_other(truth.position_px[n], i) > 2.0 * size_px;
    });
    RecordProperty("found_" + rig.markers[i].id, std::to_string(got.found()));
    EXPECT_EQ(got.wrong, 0) << rig.markers[i].id << ", at worst " << got.worst_px << " px off";
    EXPECT_GE(got.found(), 0.95) << rig.markers[i].id << ": " << got.missed << " of " << got.due
                                 << " (" << result.tracks[i].lost_because << ")";
    EXPECT_GT(got.due, 60) << rig.markers[i].id;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Speeds,
    CrossingMarkers,
    ::testing::Values(
        // One passes a fixed one, slowly, at several distances.
        Crossing{"SlowlyPastAFixedOne", -12, 6, 1.5, across(-22, 4.0), {}, 1},
        Crossing{"OverAFixedOne", -12, 8, 0.0, across(-24, 6.0), {}, 2},
        Crossing{"FastPastAFixedOne", -10, 4, 2.0, across(-24, 14.0, 4.0), {}, 3},
        Crossing{"VeryFastPastAFixedOne", -10, 4, 2.5, across(-20, 24.0, 5.0, 0.0, 0.1), {}, 4},
        // Both move.
        Crossing{"AgainstEachOther", -12, 12, 1.5, across(-16, 5.0), across(16, 5.0), 5},
        Crossing{"OnOneLine", -12, 12, 0.0, across(-14, 4.0), across(14, 7.0), 6},
        Crossing{"OvertakingAtOtherRates", -8, 8, 1.0, across(-18, 9.0, 3.0), across(-18, 7.3), 7},
        Crossing{
            "FastAgainstEachOther", -10, 10, 2.5, across(-18, 15.0, 5.0), across(18, 13.0, 5.0), 8},
        Crossing{"ReleasedOneAfterTheOther",
                 -10,
                 10,
                 2.0,
                 across(-20, 11.0, 4.0, 0.0, 0.05),
                 across(16, 12.0, 4.0, 0.0, 0.2),
                 9},
        Crossing{"NeverApartForLong",
                 -3,
                 3,
                 1.6,
                 across(-12, 8.0, 1.0, 0.4),
                 across(12, 8.5, 1.0, 0.4),
                 10}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace twang::test
