// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "harmonic_inversion/select_modes.hpp"

#include <fmt/format.h>

namespace twang {

void SelectionOptions::check() const {
  if (!(step_s > 0.0)) {
    throw InputError(fmt::format("SelectionOptions.step_s is {}, must be > 0", step_s));
  }
  if (!(band_hz.low_hz >= 0.0 && band_hz.high_hz > band_hz.low_hz)) {
    throw InputError(fmt::format("SelectionOptions.band_hz is {} to {}, must rise from 0 or above",
                                 band_hz.low_hz,
                                 band_hz.high_hz));
  }
  if (!(false_alarm_rate > 0.0 && false_alarm_rate < 1.0)) {
    throw InputError(fmt::format("SelectionOptions.false_alarm_rate is {}, must be within (0, 1)",
                                 false_alarm_rate));
  }
  if (max_candidates < 1) {
    throw InputError(
        fmt::format("SelectionOptions.max_candidates is {}, must be at least 1", max_candidates));
  }
}

}  // namespace twang
