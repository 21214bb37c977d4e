// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/ffmpeg_calls.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <stdexcept>

namespace twang::detail {
namespace {

void* open_ffmpeg() {
  // It brings the others: their functions are found by its handle, too.
  constexpr const char* kLibrary = "libavformat.so." AV_STRINGIFY(LIBAVFORMAT_VERSION_MAJOR);
  void* library = dlopen(kLibrary, RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr)
    throw std::runtime_error(fmt::format("films need FFmpeg's {}: {}", kLibrary, dlerror()));
  return library;
}

}  // namespace

void* find_in_ffmpeg(const char* name) {
  static void* const library = open_ffmpeg();
  void* function = dlsym(library, name);
  if (function == nullptr)
    throw std::runtime_error(fmt::format("FFmpeg has no function {}: {}", name, dlerror()));
  return function;
}

}  // namespace twang::detail
