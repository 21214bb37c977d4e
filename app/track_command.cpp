// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "app/track_report.hpp"
#include "capture/track_markers.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <utility>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

struct TrackCommand {
  std::string rig;
  std::vector<std::string> videos;
  std::string output;
  std::string overlay;
  std::string sheet;
  std::string folder;
  bool overlays = false;
  std::string json;
  TrackFlags flags;
};

/// Where the results of one film go; empty: not wanted.
struct TrackTargets {
  fs::path trace;
  fs::path overlay;
  fs::path sheet;
};

void check_outputs(const TrackCommand& command) {
  if (command.output.empty() && command.folder.empty()) {
    throw InputError(
        "neither -o nor --out is given, must be -o trace.csv for one film or --out "
        "DIR for any number");
  }
  if (!command.output.empty() && !command.folder.empty()) {
    throw InputError("both -o and --out are given, must be one of the two");
  }
  if (!command.output.empty() && command.videos.size() > 1) {
    throw InputError(fmt::format(
        "-o names one trace for {} films, must be --out DIR, which gets a trace for each",
        command.videos.size()));
  }
  if (!command.folder.empty() && !(command.overlay.empty() && command.sheet.empty())) {
    throw InputError(
        fmt::format("{} goes with -o, must be {} with --out",
                    command.overlay.empty() ? "--sheet" : "--overlay",
                    command.overlay.empty() ? "left out (each film gets one)" : "--overlays"));
  }
  if (command.folder.empty() && command.overlays) {
    throw InputError("--overlays goes with --out, must be --overlay FILE with -o");
  }
}

TrackTargets targets_in(const fs::path& folder, const fs::path& film, bool overlay) {
  const std::string stem = film.stem().string();
  return {folder / (stem + ".csv"),
          overlay ? folder / (stem + "_overlay.mp4") : fs::path(),
          folder / (stem + ".png")};
}

/// No two films may write one file, and none may write over a film.
void check_targets(const std::vector<std::pair<fs::path, TrackTargets>>& films) {
  std::map<fs::path, fs::path> written_by;
  for (const auto& [film, targets] : films) {
    for (const fs::path& target : {targets.trace, targets.overlay, targets.sheet}) {
      if (target.empty()) continue;
      const auto [at, fresh] = written_by.emplace(target.lexically_normal(), film);
      if (!fresh) {
        throw InputError(
            fmt::format("{} and {} would both write {}, must be films of different names",
                        at->second.string(),
                        film.string(),
                        target.string()));
      }
      for (const auto& [other, unused] : films) {
        std::error_code ignored;
        if (fs::equivalent(target, other, ignored)) {
          throw InputError(fmt::format("{} would be written over by a result, must be another file",
                                       other.string()));
        }
      }
    }
  }
}

std::vector<std::pair<fs::path, TrackTargets>> plan_films(const TrackCommand& command) {
  std::vector<std::pair<fs::path, TrackTargets>> films;
  for (const std::string& video : command.videos) {
    films.emplace_back(video,
                       command.folder.empty()
                           ? TrackTargets{command.output, command.overlay, command.sheet}
                           : targets_in(command.folder, video, command.overlays));
  }
  check_targets(films);
  return films;
}

/// Tracks one film; its files appear together, after the last of them is made.
TrackResult track_film(const Rig& rig,
                       const fs::path& film,
                       const TrackTargets& targets,
                       TrackOptions options) {
  options.overlay = targets.overlay;
  TrackResult result = track_markers(rig, film, options);
  write_trace_csv(targets.trace, result.trace);
  if (!targets.sheet.empty()) write_contact_sheet(targets.sheet, rig, film, result);
  return result;
}

/// The same into a folder that is made if it is not there.
TrackResult track_film_into(const std::string& folder,
                            const Rig& rig,
                            const fs::path& film,
                            bool overlay,
                            const TrackOptions& options) {
  OutputFolder output(folder);
  TrackResult result = track_film(rig, film, targets_in(output.file(""), film, overlay), options);
  output.commit();
  return result;
}

/// The films of a call, one after the other; one that fails does not keep the others from their
/// turn.
class Batch {
 public:
  Batch(const TrackCommand& command, const Rig& rig)
      : m_command(command), m_rig(rig), m_options(command.flags.options()) {
    m_films = plan_films(command);
    m_options.progress = terminal_progress([this] {
      return m_films.size() == 1 ? std::string()
                                 : fmt::format("film {} of {}", m_current + 1, m_films.size());
    });
  }

  void run() {
    for (m_current = 0; m_current < m_films.size(); ++m_current) {
      try {
        track_current();
      } catch (const Cancelled&) {
        if (m_num_done == 0) throw;
        write_summary();
        throw Cancelled(fmt::format(
            "interrupted, the results of {} of {} films are written", m_num_done, m_films.size()));
      }
    }
    write_summary();
    if (m_num_failed > 0) {
      throw InputError(
          fmt::format("{} of {} films could not be tracked", m_num_failed, m_films.size()));
    }
  }

 private:
  void track_current() {
    const auto& [film, targets] = m_films[m_current];
    try {
      const TrackResult result =
          m_command.folder.empty()
              ? track_film(m_rig, film, targets, m_options)
              : track_film_into(m_command.folder, m_rig, film, m_command.overlays, m_options);
      ++m_num_done;
      say((m_films.size() > 1 ? film.string() + ": " : "") + track_summary_text(m_rig, result));
      m_summaries.push_back(track_summary_json(m_rig, film, result));
    } catch (const InputError& error) {
      if (m_films.size() == 1) throw;
      ++m_num_failed;
      say(fmt::format("twang: {}", error.what()));
      m_summaries.push_back({{"film", film.string()}, {"error", error.what()}});
    }
  }

  void write_summary() const {
    if (m_command.json.empty()) return;
    const nlohmann::ordered_json json = {{"format", "twang-track/1"}, {"films", m_summaries}};
    write_json(m_command.json, json.dump(2) + "\n");
  }

  const TrackCommand& m_command;
  const Rig& m_rig;
  TrackOptions m_options;
  std::vector<std::pair<fs::path, TrackTargets>> m_films;
  std::size_t m_current = 0;
  std::size_t m_num_done = 0;
  std::size_t m_num_failed = 0;
  nlohmann::ordered_json m_summaries = nlohmann::ordered_json::array();
};

void run(const TrackCommand& command) {
  check_outputs(command);
  RigNeeds needs;
  needs.film = true;
  const Rig rig = load_rig(command.rig, needs);
  Batch(command, rig).run();
}

}  // namespace

void add_track_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("track", "Track the markers of film(s) into traces");
  auto command = std::make_shared<TrackCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("videos", command->videos, "film(s)")->required();
  sub->add_option("-o,--output", command->output, "trace of one film (*.csv)");
  sub->add_option("--overlay", command->overlay, "with -o: film with the tracks drawn in (*.mp4)");
  sub->add_option("--sheet", command->sheet, "with -o: contact sheet (*.png)");
  sub->add_option("--out",
                  command->folder,
                  "folder for the results of any number of films: NAME.csv and NAME.png each");
  sub->add_flag("--overlays", command->overlays, "with --out: NAME_overlay.mp4 as well");
  sub->add_option(
      "--json", command->json, "summary for programs: a file, or - for standard output");
  command->flags.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
