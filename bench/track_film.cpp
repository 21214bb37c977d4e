// SPDX-License-Identifier: GPL-3.0-or-later
// Time of tracking eight markers in a 1080p film beside that of decoding it, and memory over the
// length of a film.
//
// The film of the defaults has 19 kB a frame, 36 Mbit/s at 240 frames/s, as a telephone writes it;
// the less a film says, the sooner it is decoded, and the more tracking weighs beside it.
//
//   track_film [--frames 600] [--crf 15] [--repeats 5] [--overlay] [--memory] [--folder DIR]
#include "capture/detail/doubled_frames.hpp"
#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"
#include "core/constants.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace {

using namespace twang;
namespace fs = std::filesystem;

constexpr double kFps = 240.0;
constexpr double kLength_m = 80e-3;
constexpr double kMarker_m = 2.35e-3;      // 40 px where the picture is 1920 px wide
constexpr double kLargeMarker_m = 6.0e-3;  // 17 px where it is 320 px wide

struct Settings {
  fs::path folder = fs::temp_directory_path() / "twang_bench";
  int frames = 600;
  int crf = 15;
  int repeats = 5;
  bool overlay = false;
  bool memory = false;
};

/// A strip with four crosses, four dots on the bench around it.
Rig bench_rig(double size_m = kMarker_m) {
  Rig rig;
  rig.name = "bench";
  const auto add = [&](std::string id, MarkerKind kind, const Eigen::Vector3d& at, bool fixed) {
    Marker marker;
    marker.id = std::move(id);
    marker.kind = kind;
    marker.size_m = size_m;
    marker.position = at;
    marker.fixed = fixed;
    rig.markers.push_back(marker);
  };
  add("tip", MarkerKind::Cross, {78e-3, 0.0, 1e-3}, false);
  add("second", MarkerKind::Cross, {62e-3, 0.0, 1e-3}, false);
  add("third", MarkerKind::Cross, {45e-3, 0.0, 1e-3}, false);
  add("fourth", MarkerKind::Cross, {29e-3, 0.0, 1e-3}, false);
  add("upper left", MarkerKind::Dot, {-9e-3, 0.0, 23e-3}, true);
  add("upper right", MarkerKind::Dot, {91e-3, 0.0, 25e-3}, true);
  add("lower right", MarkerKind::Dot, {88e-3, 0.0, -24e-3}, true);
  add("lower left", MarkerKind::Dot, {-6e-3, 0.0, -21e-3}, true);
  rig.observable =
      ObservableDefinition{ObservableKind::Displacement, {"tip"}, Eigen::Vector3d::UnitZ()};
  rig.release = Release{{kLength_m, 0.0, 1e-3}, Eigen::Vector3d(0.0, 0.0, -3e-3), std::nullopt};
  rig.camera = Camera{};
  return rig;
}

/// First bending, held for a tenth of a second, then free.
FilmedState strip_at(const Rig& rig, double time_s, double decay_per_s) {
  const double t = std::max(0.0, time_s - 0.1);
  const double end = -3e-3 * std::exp(-decay_per_s * t) * std::cos(kTwoPi * 40.0 * t);
  const auto deflection = [&](double x) {
    const double s = std::max(0.0, x / kLength_m);
    return end * 0.5 * s * s * (3.0 - s);
  };
  FilmedState state;
  for (const Marker& marker : rig.markers) {
    state.markers.push_back({marker.position, 0.0});
    if (!marker.fixed) state.markers.back().position.z() += deflection(marker.position.x());
  }
  constexpr int kPieces = 16;
  for (int i = 0; i < kPieces; ++i) {
    const double x0 = kLength_m * i / kPieces;
    const double x1 = kLength_m * (i + 1) / kPieces;
    state.part_faces.push_back({Eigen::Vector3d(x0, 0.0, deflection(x0)),
                                Eigen::Vector3d(x1, 0.0, deflection(x1)),
                                Eigen::Vector3d(x1, 0.0, 2e-3 + deflection(x1)),
                                Eigen::Vector3d(x0, 0.0, 2e-3 + deflection(x0))});
  }
  return state;
}

fs::path film_1080p(const Settings& settings) {
  const fs::path path =
      settings.folder / fmt::format("strip_{}_{}.mp4", settings.frames, settings.crf);
  if (fs::exists(path)) return path;
  fmt::print("rendering {} ...\n", path.string());
  std::fflush(stdout);
  const Rig rig = bench_rig();
  FilmOptions options;
  options.width_px = 1920;
  options.height_px = 1080;
  options.fps = kFps;
  options.duration_s = settings.frames / kFps;
  options.crf = settings.crf;
  render_film(
      rig, [&](double time_s) { return strip_at(rig, time_s, 4.0); }, path, options);
  return path;
}

struct Cost {
  double wall_s = 0.0;
  double processor_s = 0.0;  // of all threads
};

double processor_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

Cost cost_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  const double processor_before = processor_s();
  work();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          processor_s() - processor_before};
}

Cost median(std::vector<Cost> costs) {
  const auto middle_of = [&](double Cost::*part) {
    const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2);
    std::nth_element(costs.begin(), middle, costs.end(), [&](const Cost& a, const Cost& b) {
      return a.*part < b.*part;
    });
    return (*middle).*part;
  };
  return {middle_of(&Cost::wall_s), middle_of(&Cost::processor_s)};
}

void decode(const fs::path& film) {
  VideoReader reader(film);
  while (reader.read()) {
  }
}

void decode_and_compare(const fs::path& film) {
  VideoReader reader(film);
  detail::DoubledFrames doubled;
  while (const auto frame = reader.read()) doubled.add(*frame);
}

/// All ways of going through the film, one after the other, several times over, so that what else
/// the machine does hits all alike.
void measure_time(const Settings& settings) {
  const fs::path film = film_1080p(settings);
  const Rig rig = bench_rig();
  TrackResult tracked;
  struct Way {
    const char* name;
    std::function<void()> work;
    std::vector<Cost> costs = {};
  };
  std::vector<Way> ways = {
      {"decoding", [&] { decode(film); }},
      {"decoding, comparing neighbours", [&] { decode_and_compare(film); }},
      {"tracking", [&] { tracked = track_markers(rig, film); }},
  };
  if (settings.overlay) {
    ways.push_back({"tracking, writing the overlay", [&] {
                      TrackOptions options;
                      options.overlay = settings.folder / "overlay.mp4";
                      tracked = track_markers(rig, film, options);
                    }});
  }
  for (int i = 0; i < settings.repeats; ++i) {
    for (Way& way : ways) way.costs.push_back(cost_of(way.work));
  }
  const double frames = tracked.time_base.frames > 0
                            ? tracked.time_base.frames
                            : static_cast<double>(tracked.trace.time_s.size());
  const Cost decoding = median(ways[0].costs);
  fmt::print("{} frames of 1920 x 1080 px, {} markers of 40 px, {} bytes a frame; {} doubled\n",
             frames,
             rig.markers.size(),
             static_cast<double>(fs::file_size(film)) / frames,
             tracked.time_base.doubled);
  fmt::print("{:<32}{:>10}{:>8}{:>16}{:>8}\n", "", "ms/frame", "ratio", "processor ms", "ratio");
  for (const Way& way : ways) {
    const Cost cost = median(way.costs);
    fmt::print("{:<32}{:>10.3f}{:>8.2f}{:>16.3f}{:>8.2f}\n",
               way.name,
               1e3 * cost.wall_s / frames,
               cost.wall_s / decoding.wall_s,
               1e3 * cost.processor_s / frames,
               cost.processor_s / decoding.processor_s);
  }
}

/// Small pictures of an undamped vibration of six frames a period, over and over.
fs::path long_film(const Settings& settings, int frames) {
  const fs::path path = settings.folder / fmt::format("long_{}.mp4", frames);
  if (fs::exists(path)) return path;
  const Rig rig = bench_rig(kLargeMarker_m);
  const fs::path loop = settings.folder / "loop.mkv";
  FilmOptions options;
  options.width_px = 320;
  options.height_px = 180;
  options.duration_s = 60.0 / kFps;
  options.crf = 0;
  render_film(
      rig, [&](double time_s) { return strip_at(rig, time_s + 0.1, 0.0); }, loop, options);
  std::vector<Image> images;
  VideoReader reader(loop);
  while (const auto frame = reader.read()) {
    Image& image = images.emplace_back(Image{frame->width_px, frame->height_px, 1, {}});
    for (int y = 0; y < frame->height_px; ++y) {
      const std::uint8_t* row = frame->pixels + y * frame->stride;
      image.pixels.insert(image.pixels.end(), row, row + frame->width_px);
    }
  }
  VideoWriter writer(
      path, options.width_px, options.height_px, {.fps = kFps, .crf = settings.crf, .quick = true});
  for (int n = 0; n < frames; ++n)
    writer.write(images[static_cast<std::size_t>(n) % images.size()]);
  writer.finish();
  return path;
}

/// Largest memory of a process of its own that does `work` [bytes].
double peak_memory(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  rusage usage{};
  int status = 0;
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) return kNaN;
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void measure_memory(const Settings& settings) {
  const Rig rig = bench_rig(kLargeMarker_m);
  fmt::print("{:>8}{:>24}{:>26}\n", "frames", "tracking, peak [MB]", "decoding alone, peak [MB]");
  double first = 0.0;
  double last = 0.0;
  const std::vector<int> lengths = {1000, 10000, 100000};
  for (const int frames : lengths) {
    const fs::path film = long_film(settings, frames);
    last = peak_memory([&] { static_cast<void>(track_markers(rig, film)); });
    if (frames == lengths.front()) first = last;
    fmt::print("{:>8}{:>24.1f}{:>26.1f}\n", frames, 1e-6 * last, 1e-6 * peak_memory([&] {
                                                                   decode(film);
                                                                 }));
    std::fflush(stdout);
  }
  fmt::print("{:.0f} bytes a frame, with {} markers\n",
             (last - first) / (lengths.back() - lengths.front()),
             rig.markers.size());
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Time and memory of tracking a film");
  app.add_option("--folder", settings.folder, "where the rendered films are kept");
  app.add_option("--frames", settings.frames, "length of the film");
  app.add_option("--crf", settings.crf, "H.264 rate factor of the film");
  app.add_option("--repeats", settings.repeats, "runs of each kind");
  app.add_flag("--overlay", settings.overlay, "with the overlay too");
  app.add_flag(
      "--memory", settings.memory, "peak memory of films of 1e3, 1e4 and 1e5 frames instead");
  CLI11_PARSE(app, argc, argv);
  fs::create_directories(settings.folder);
  if (settings.memory) {
    measure_memory(settings);
  } else {
    measure_time(settings);
  }
  return 0;
}
