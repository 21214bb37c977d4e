// SPDX-License-Identifier: GPL-3.0-or-later
// How many repeated frames are found, missed and called falsely, in rendered films of a plucked
// strip at random frequencies, by compression.
//
//   doubled_frames [--seeds 1 10] [--film NAME]
#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "tests/capture/filmed_strip.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace twang;
namespace fs = std::filesystem;

// A repeat of a compressed film that hides less, or of a part still held, leaves no trace. [px]
constexpr double kSeen_px = 0.3;

struct Kind {
  const char* name;
  int crf;
  double noise;
  bool troubled;  // blur of half a frame, tilt, shake, flicker
  double doubled;
  double duration_s;
  double decay_per_s;
};

constexpr Kind kKinds[] = {{"lossless, noise 2, 5 % doubled", 0, 2.0, false, 0.05, 0.4, 8.0},
                           {"crf 27, all troubles, 5 % doubled", 27, 4.0, true, 0.05, 0.4, 4.0},
                           {"crf 14, 5 % doubled", 14, 2.0, false, 0.05, 0.8, 4.0},
                           {"crf 17, 5 % doubled", 17, 2.0, false, 0.05, 0.8, 6.0},
                           {"crf 22, 5 % doubled", 22, 2.0, false, 0.05, 0.8, 6.0},
                           {"crf 14, none doubled", 14, 2.0, false, 0.0, 2.0, 6.0},
                           {"crf 16, none doubled", 16, 2.0, false, 0.0, 2.0, 6.0},
                           {"crf 18, none doubled", 18, 2.0, false, 0.0, 2.0, 4.0},
                           {"crf 22, none doubled", 22, 2.0, false, 0.0, 1.5, 6.0},
                           {"crf 27, all troubles, none doubled", 27, 4.0, true, 0.0, 1.0, 4.0}};

struct Score {
  int frames = 0;
  int found = 0;
  int missed = 0;  // though motion or noise gave them away
  int hidden = 0;  // compressed, and nothing moved
  int falsely = 0;
};

void add_film(const Kind& kind, unsigned seed, Score& score) {
  std::mt19937 random(77 * seed + 13);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  FilmOptions options;
  options.width_px = 480;
  options.height_px = 270;
  options.duration_s = kind.duration_s;
  options.crf = kind.crf;
  options.noise = kind.noise;
  options.doubled = kind.doubled;
  options.seed = 1000 + seed;
  if (kind.troubled) {
    options.exposure = 0.5;
    options.tilt_deg = between(-8.0, 8.0);
    options.shake_px = seed % 2;
    options.flicker = 0.1;
  }
  test::StripMotion motion;
  motion.frequency_hz = between(12.0, 70.0);
  motion.decay_per_s = kind.decay_per_s * between(0.5, 1.5);
  const Rig rig = test::strip_rig();
  const fs::path path = fs::temp_directory_path() / fmt::format("doubled_{}.mkv", getpid());
  const FilmTruth truth = render_film(
      rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
  const TrackResult result = track_markers(rig, path);
  fs::remove(path);
  const std::vector<double>& observable = result.trace.find("observable_mm")->values;
  std::size_t shown = 0;
  for (std::size_t n = 0; n < truth.doubled.size(); ++n) {
    ++score.frames;
    const bool called = std::isnan(observable[n]);
    if (!truth.doubled[n]) {
      shown = n;
      score.falsely += called ? 1 : 0;
      continue;
    }
    const double step_px = (truth.position_px[n][0] - truth.position_px[shown][0]).norm();
    const bool shows = kind.crf == 0 || step_px > kSeen_px;
    ++(called ? score.found : shows ? score.missed : score.hidden);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<unsigned> seeds = {1, 10};
  std::string only;
  CLI::App cli{"Repeated frames found, missed and called falsely"};
  cli.add_option("--seeds", seeds, "first and last")->expected(2)->capture_default_str();
  cli.add_option("--film", only, "kinds of film whose names hold this");
  CLI11_PARSE(cli, argc, argv);
  fmt::print("{:36} {:>7} {:>6} {:>6} {:>6} {:>6}\n",
             "film",
             "frames",
             "found",
             "missed",
             "hidden",
             "false");
  for (const Kind& kind : kKinds) {
    if (std::string(kind.name).find(only) == std::string::npos) continue;
    Score score;
    for (unsigned seed = seeds[0]; seed <= seeds[1]; ++seed) add_film(kind, seed, score);
    fmt::print("{:36} {:7} {:6} {:6} {:6} {:6}\n",
               kind.name,
               score.frames,
               score.found,
               score.missed,
               score.hidden,
               score.falsely);
    std::fflush(stdout);
  }
  return 0;
}
