// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/App.hpp>

namespace twang::app {

/// Each adds one command with its options to the command line; its work is done in the callback
/// CLI11 keeps.
void add_calibrate_command(CLI::App& cli);
void add_track_command(CLI::App& cli);
void add_invert_command(CLI::App& cli);
void add_modes_command(CLI::App& cli);
void add_coarsen_command(CLI::App& cli);
void add_identify_command(CLI::App& cli);
void add_table_command(CLI::App& cli);
void add_predict_command(CLI::App& cli);
void add_rheology_command(CLI::App& cli);
void add_render_command(CLI::App& cli);
void add_check_command(CLI::App& cli);
void add_markers_command(CLI::App& cli);
void add_simulate_command(CLI::App& cli);
void add_validate_command(CLI::App& cli);

}  // namespace twang::app
