// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "core/error.hpp"
#include "simulate/run_scene.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

namespace twang::app {
namespace {

struct SimulateCommand {
  std::string scene;
  std::string out;
  bool resume = false;
  int threads = 0;
};

void run(const SimulateCommand& command) {
  const Scene scene = load_scene(command.scene);
  SceneOptions options;
  options.folder = command.out;
  options.resume = command.resume;
  options.threads = command.threads;
  options.progress = terminal_progress();
  const SceneSummary summary = run_scene(scene, options);
  const double steps = std::max(summary.run.steps, 1);
  std::string text;
  if (summary.resumed_at_step > 0)
    text += fmt::format("resumed at {:.6g} s\n",
                        static_cast<double>(summary.resumed_at_step) * scene.step_s);
  text += fmt::format(
      "{:.6g} s in {} steps, {:.3g} s a step, {:.2f} Newton iterations each; energy unaccounted "
      "for: {:.2g} of the largest\nresults are in {}\n",
      summary.simulated_s,
      summary.run.steps,
      summary.wall_s / steps,
      static_cast<double>(summary.run.newton_iterations) / steps,
      summary.remainder_rel,
      command.out);
  print_result(text);
  if (!summary.usable())
    throw NumericalFailure(
        fmt::format("{} (what was simulated until then is kept)", summary.run.message));
}

}  // namespace

void add_simulate_command(CLI::App& cli) {
  CLI::App* sub =
      cli.add_subcommand("simulate", "Bodies in time: gravity, loads and their release, flight");
  auto command = std::make_shared<SimulateCommand>();
  sub->add_option("scene", command->scene, "scene file (*.toml)")->required();
  sub->add_option("--out", command->out, "folder for the results")->required();
  sub->add_flag("--resume", command->resume, "go on from the checkpoint in that folder");
  sub->add_option(
      "--threads", command->threads, "threads, always as many; default: as many as are idle");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
