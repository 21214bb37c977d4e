// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stdexcept>
#include <string_view>

namespace twang {

/// How far a long computation has come.
struct Progress {
  std::string_view stage;  ///< what is being done, in a few words ("tracking")
  double done = 0.0;       ///< in the unit of `total` [-]
  double total = 0.0;      ///< 0 when it is not known [-]
};

/// Called now and then by long computations; returns false to ask for a stop.
using ProgressCallback = std::function<bool(const Progress&)>;

/// Thrown out of a computation whose callback asked for a stop; nothing half-written is left
/// behind. The command line turns it into exit code 130.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("interrupted") {}
};

/// Tells `callback` (if there is one) where the work stands.
/// @throws Cancelled if the callback returns false
inline void report_progress(const ProgressCallback& callback, const Progress& progress) {
  if (callback && !callback(progress)) throw Cancelled();
}

}  // namespace twang
