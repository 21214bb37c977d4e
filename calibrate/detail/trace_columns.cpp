// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/trace_columns.hpp"

#include "core/error.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/observable.hpp"

#include <fmt/format.h>

namespace twang::detail {

std::vector<std::string> columns_to_invert(const Rig& rig,
                                           const Trace& trace,
                                           const std::filesystem::path& file,
                                           const std::vector<std::string>& asked) {
  for (const std::string& column : asked) {
    if (trace.find(column) == nullptr) {
      throw InputError(fmt::format("{}: has no column '{}'", file.string(), column));
    }
  }
  if (!asked.empty()) return asked;
  if (rig.observable) {
    const std::string column = observable_column(rig.observable->kind);
    if (trace.find(column) != nullptr) return {column};
  }
  return default_columns(trace);
}

}  // namespace twang::detail
