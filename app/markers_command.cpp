// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "capture/marker_sheet.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

struct MarkersCommand {
  std::string rig;
  std::string output;
};

/// "sheet.svg" alone, "sheet_2.svg" of several.
fs::path page_file(const fs::path& output, std::size_t page, std::size_t count) {
  if (count == 1) return output;
  fs::path numbered = output;
  return numbered.replace_filename(
      fmt::format("{}_{}{}", output.stem().string(), page + 1, output.extension().string()));
}

void run(const MarkersCommand& command) {
  const fs::path output(command.output);
  if (output.extension() != ".svg") {
    throw InputError(fmt::format("-o is '{}', must be a file that ends in .svg", command.output));
  }
  const MarkerSheet sheet = draw_marker_sheet(load_rig(command.rig));
  for (std::size_t i = 0; i < sheet.pages.size(); ++i) {
    const fs::path file = page_file(output, i, sheet.pages.size());
    write_file_atomically(file, sheet.pages[i]);
    say(fmt::format("{}: print at 100 % scale and check the ruler", file.string()));
  }
  for (const std::string& id : sheet.not_printed) {
    say(fmt::format("note: '{}' is a patch of natural texture, nothing is printed for it", id));
  }
}

}  // namespace

void add_markers_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("markers", "A rig's markers to print, true to scale (SVG)");
  auto command = std::make_shared<MarkersCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("-o,--output",
                  command->output,
                  "page to write (*.svg); several pages become NAME_1.svg, NAME_2.svg ...")
      ->required();
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
