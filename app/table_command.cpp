// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "report/material_table.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace twang::app {
namespace {

struct TableCommand {
  std::vector<std::string> folders;
  std::string format = "text";
  std::string output;
};

void run(const TableCommand& command) {
  const TableFormat format = table_format_from(command.format);
  std::vector<Material> materials;
  for (const std::string& folder : command.folders) {
    const std::filesystem::path path(folder);
    materials.push_back(
        read_material(std::filesystem::is_directory(path) ? path / "material.json" : path));
  }
  const std::string text = format_material_table(materials, format);
  if (command.output.empty()) {
    print_result(text);
  } else {
    write_file_atomically(command.output, text);
  }
}

}  // namespace

void add_table_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("table", "Many calibrations as one material table");
  auto command = std::make_shared<TableCommand>();
  sub->add_option(
         "calibrations", command->folders, "folders of calibrations, or their material.json")
      ->required();
  sub->add_option("--format", command->format, "text, csv, markdown, latex or json")
      ->capture_default_str();
  sub->add_option("-o,--output", command->output, "file to write; default: standard output");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
