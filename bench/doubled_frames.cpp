// SPDX-License-Identifier: GPL-3.0-or-later
// How many repeated frames are found, missed and called falsely, in rendered films of a plucked
// strip at random frequencies, by compression; and how many pictures a coder leaves as they were.
//
//   doubled_frames [--seeds 1 10] [--film NAME]
#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "tests/capture/filmed_strip.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace twang;
namespace fs = std::filesystem;

// A repeat hides what the markers did in its time. Where compression has taken the noise away and
// no lamp flickers it shows in that alone, and coders leave honest pictures where they were, too,
// if little moved: `left out` counts those, with the longest step. So one that hides less than
// this, or than four standard errors of the film's samples about it, need not be found. [px]
constexpr double kSeen_px = 0.3;
constexpr double kSeen = 4.0;
constexpr std::size_t kAbout = 12;    // frames on either side
constexpr double kLeftOut_px = 0.16;  // steps of less are not counted
constexpr double kStands = 0.15;      // of the step, the marker's own

enum class Picture {
  Good,
  Troubled,
  Any
};  // blur of half a frame, tilt, shake, flicker; at random

struct Kind {
  const char* name;
  int crf;
  double noise;
  Picture picture;
  double doubled;
  double duration_s;
  double decay_per_s;
  bool at_rest = false;
};

constexpr Kind kKinds[] = {
    {"lossless, noise 2, 5 % doubled", 0, 2.0, Picture::Good, 0.05, 0.4, 8.0},
    {"crf 27, all troubles, 5 % doubled", 27, 4.0, Picture::Troubled, 0.05, 0.4, 4.0},
    {"crf 14, 5 % doubled", 14, 2.0, Picture::Good, 0.05, 0.8, 4.0},
    {"crf 17, 5 % doubled", 17, 2.0, Picture::Good, 0.05, 0.8, 6.0},
    {"crf 22, 5 % doubled", 22, 2.0, Picture::Good, 0.05, 0.8, 6.0},
    {"at random, 5 % doubled", 0, 0.0, Picture::Any, 0.05, 1.0, 0.0},
    {"crf 14, none doubled", 14, 2.0, Picture::Good, 0.0, 2.0, 6.0},
    {"crf 16, none doubled", 16, 2.0, Picture::Good, 0.0, 2.0, 6.0},
    {"crf 18, none doubled", 18, 2.0, Picture::Good, 0.0, 2.0, 4.0},
    {"crf 22, none doubled", 22, 2.0, Picture::Good, 0.0, 1.5, 6.0},
    {"crf 27, all troubles, none doubled", 27, 4.0, Picture::Troubled, 0.0, 1.0, 4.0},
    {"at random, none doubled", 0, 0.0, Picture::Any, 0.0, 1.0, 0.0},
    {"at random, at rest, none doubled", 0, 0.0, Picture::Any, 0.0, 1.0, 0.0, true}};

struct Score {
  int frames = 0;
  int found = 0;
  int missed = 0;  // though motion, noise or the lamp gave them away
  int hidden = 0;  // compressed, and they hide too little
  double most_hidden_px = 0.0;
  int falsely = 0;
  int left_out = 0;  // honest pictures that the coder left as they were
  double most_left_out_px = 0.0;
};

class Random {
 public:
  explicit Random(unsigned seed) : m_random(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(m_random);
  }
  double in_ratio(double low, double high) {
    return std::exp(between(std::log(low), std::log(high)));
  }
  bool happens(double probability) { return between(0.0, 1.0) < probability; }

 private:
  std::mt19937 m_random;
};

/// Any compression, noise, light and motion.
void vary(Random& random, FilmOptions& options, test::StripMotion& motion) {
  options.crf = static_cast<int>(random.between(14.0, 31.0));
  options.noise = random.between(0.5, 5.0);
  options.tilt_deg = random.between(-8.0, 8.0);
  if (random.happens(0.4)) options.exposure = random.between(0.0, 0.5);
  if (random.happens(0.3)) options.shake_px = random.between(0.1, 1.5);
  if (random.happens(0.2)) options.flicker = random.between(0.01, 0.1);
  if (random.happens(0.3)) {
    options.width_px *= 2;
    options.height_px *= 2;
  }
  motion.amplitude_m *= random.in_ratio(0.05, 1.0);
  motion.frequency_hz = random.in_ratio(2.0, 110.0);
  motion.decay_per_s = random.in_ratio(0.4, 20.0);
  motion.release_s = random.between(0.0, 0.4);
}

/// Standard error of the samples about a frame that are no repeats [px].
double error_about(const FilmTruth& truth, const MarkerTrack& track, std::size_t frame) {
  double sum = 0.0;
  double count = 0.0;
  const std::size_t end = std::min(frame + kAbout + 1, truth.doubled.size());
  for (std::size_t n = frame - std::min(frame, kAbout); n < end; ++n) {
    if (truth.doubled[n] || !track.position_px[n].allFinite()) continue;
    sum += (track.position_px[n] - truth.position_px[n][0]).squaredNorm();
    count += 1.0;
  }
  return std::sqrt(sum / std::max(1.0, count));
}

void add_film(const Kind& kind, unsigned seed, Score& score) {
  Random random(77 * seed + 13);
  FilmOptions options;
  options.width_px = 480;
  options.height_px = 270;
  options.duration_s = kind.duration_s;
  options.crf = kind.crf;
  options.noise = kind.noise;
  options.doubled = kind.doubled;
  options.seed = 1000 + seed;
  test::StripMotion motion;
  if (kind.picture == Picture::Any) {
    vary(random, options, motion);
  } else {
    if (kind.picture == Picture::Troubled) {
      options.exposure = 0.5;
      options.tilt_deg = random.between(-8.0, 8.0);
      options.shake_px = seed % 2;
      options.flicker = 0.1;
    }
    motion.frequency_hz = random.between(12.0, 70.0);
    motion.decay_per_s = kind.decay_per_s * random.between(0.5, 1.5);
  }
  if (kind.at_rest) motion.amplitude_m = 0.0;
  const Rig rig = test::strip_rig();
  const fs::path path = fs::temp_directory_path() / fmt::format("doubled_{}.mkv", getpid());
  const FilmTruth truth = render_film(
      rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
  const TrackResult result = track_markers(rig, path);
  fs::remove(path);
  const std::vector<Eigen::Vector2d>& tracked_px = result.tracks[0].position_px;
  std::size_t shown = 0;
  for (std::size_t n = 0; n < truth.doubled.size(); ++n) {
    ++score.frames;
    const bool called = result.doubled[n];
    const double step_px = (truth.position_px[n][0] - truth.position_px[shown][0]).norm();
    if (!truth.doubled[n]) {
      score.falsely += called ? 1 : 0;
      const double tracked_step_px = (tracked_px[n] - tracked_px[shown]).norm();
      shown = n;
      if (step_px < kLeftOut_px || !(tracked_step_px < kStands * step_px)) continue;
      ++score.left_out;
      score.most_left_out_px = std::max(score.most_left_out_px, step_px);
      continue;
    }
    const double least_px = std::max(kSeen_px, kSeen * error_about(truth, result.tracks[0], n));
    const bool shows = options.crf == 0 || options.flicker > 0.0 || step_px > least_px;
    ++(called ? score.found : shows ? score.missed : score.hidden);
    if (!called && !shows) score.most_hidden_px = std::max(score.most_hidden_px, step_px);
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
  fmt::print("{:36} {:>7} {:>6} {:>6} {:>14} {:>6} {:>14}\n",
             "film",
             "frames",
             "found",
             "missed",
             "hidden (most)",
             "false",
             "left out (most)");
  for (const Kind& kind : kKinds) {
    if (std::string(kind.name).find(only) == std::string::npos) continue;
    Score score;
    for (unsigned seed = seeds[0]; seed <= seeds[1]; ++seed) add_film(kind, seed, score);
    fmt::print("{:36} {:7} {:6} {:6} {:4} ({:.2f} px) {:6} {:5} ({:.2f} px)\n",
               kind.name,
               score.frames,
               score.found,
               score.missed,
               score.hidden,
               score.most_hidden_px,
               score.falsely,
               score.left_out,
               score.most_left_out_px);
    std::fflush(stdout);
  }
  return 0;
}
