// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace twang {

/// How far a long computation has come.
struct Progress {
  std::string_view stage;      ///< what is being done, in a few words ("tracking")
  double done = 0.0;           ///< in the unit of `total` [-]
  double total = 0.0;          ///< 0 when it is not known [-]
  std::string_view unit = {};  ///< what is counted ("frames"), if a rate of it means something
};

/// Called now and then by long computations; returns false to ask for a stop.
using ProgressCallback = std::function<bool(const Progress&)>;

/// Thrown out of a computation whose callback asked for a stop; nothing half-written is left
/// behind. The command line turns it into exit code 130.
class Cancelled : public std::runtime_error {
 public:
  /// @param message  one sentence: what stands and what does not
  explicit Cancelled(const std::string& message = "interrupted, nothing was written")
      : std::runtime_error(message) {}
};

/// Tells `callback` (if there is one) where the work stands.
/// @throws Cancelled if the callback returns false
inline void report_progress(const ProgressCallback& callback, const Progress& progress) {
  if (callback && !callback(progress)) throw Cancelled();
}

}  // namespace twang
