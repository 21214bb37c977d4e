// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "capture/track_markers.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <memory>

namespace twang::app {
namespace {

struct TrackCommand {
  std::string rig;
  std::string video;
  std::string output;
  std::string overlay;
  TrackFlags flags;
};

void summarize(const TrackResult& result) {
  const TimeBaseSummary& time = result.time_base;
  say(fmt::format("{} frames at {:.6g} frames/s ({}), {} doubled, {} missing; {:.4f} mm/px",
                  time.frames,
                  time.capture_fps,
                  time.source,
                  time.doubled,
                  time.gaps,
                  result.mm_per_px));
  for (const MarkerTrack& track : result.tracks) {
    double sigma_sum = 0.0;
    int seen = 0;
    for (const double sigma : track.sigma_px) {
      if (std::isfinite(sigma)) {
        sigma_sum += sigma;
        ++seen;
      }
    }
    std::string line = fmt::format("  {:<12} seen in {} frames, sigma {:.3f} px",
                                   track.id,
                                   seen,
                                   seen ? sigma_sum / seen : kNaN);
    if (track.frames_lost > 0)
      line += fmt::format(", lost in {} ({})", track.frames_lost, track.lost_because);
    say(line);
  }
  for (const std::string& note : result.notes) say("note: " + note);
}

void run(const TrackCommand& command) {
  RigNeeds needs;
  needs.film = true;
  const Rig rig = load_rig(command.rig, needs);
  TrackOptions options = command.flags.options();
  options.overlay = command.overlay;
  options.progress = terminal_progress();
  const TrackResult result = track_markers(rig, command.video, options);
  write_trace_csv(command.output, result.trace);
  summarize(result);
}

}  // namespace

void add_track_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("track", "Track a film's markers into a trace");
  auto command = std::make_shared<TrackCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("video", command->video, "film")->required();
  sub->add_option("-o,--output", command->output, "trace to write (*.csv)")->required();
  sub->add_option("--overlay", command->overlay, "film to write with the tracks drawn in (*.mp4)");
  command->flags.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
