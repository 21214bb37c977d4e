// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "core/error.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/version.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <string>
#include <vector>

namespace {

enum ExitCode { kDone = 0, kNumericalFailure = 1, kBadInput = 2, kInterrupted = 130 };

/// A mistyped command is named, with the nearest one; CLI11 would only say that one is required.
void refuse_unknown_command(const CLI::App& cli, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : cli.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  throw twang::InputError(
      fmt::format("'{}' is no command, did you mean '{}'? (twang --help lists them)",
                  argv[1],
                  twang::nearest_word(argv[1], names)));
}

int run_command_line(int argc, char** argv) {
  CLI::App cli{"twang: the material of a printed part from a film of its vibration"};
  cli.set_version_flag("--version", std::string("twang ") + twang::kVersion);
  cli.require_subcommand(1);
  twang::app::add_calibrate_command(cli);
  twang::app::add_track_command(cli);
  twang::app::add_invert_command(cli);
  twang::app::add_modes_command(cli);
  twang::app::add_coarsen_command(cli);
  twang::app::add_identify_command(cli);
  twang::app::add_table_command(cli);
  twang::app::add_predict_command(cli);
  twang::app::add_rheology_command(cli);
  twang::app::add_render_command(cli);
  twang::app::add_check_command(cli);
  twang::app::add_markers_command(cli);
  twang::app::add_simulate_command(cli);
  twang::app::add_validate_command(cli);
  refuse_unknown_command(cli, argc, argv);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return cli.exit(success);
  } catch (const CLI::ParseError& error) {
    throw twang::InputError(fmt::format("{} (twang --help tells the usage)", error.what()));
  }
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  using twang::app::say;
  twang::app::catch_interrupts();
  try {
    return run_command_line(argc, argv);
  } catch (const twang::InputError& error) {
    say(fmt::format("twang: {}", error.what()));
    return kBadInput;
  } catch (const twang::NumericalFailure& error) {
    say(fmt::format("twang: {}", error.what()));
    return kNumericalFailure;
  } catch (const twang::Cancelled& stop) {
    say(fmt::format("twang: {}", stop.what()));
    return kInterrupted;
  } catch (const std::bad_alloc&) {
    say("twang: the memory of this machine does not suffice; a larger --dx needs less");
    return kNumericalFailure;
  } catch (const std::exception& error) {
    say(fmt::format("twang: {}", error.what()));
    return kNumericalFailure;
  }
}
