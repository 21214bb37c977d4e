// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/ffmpeg_calls.hpp"

#include <memory>
#include <string>

namespace twang::detail {

/// Owners of FFmpeg's objects.
struct FreeCodecContext {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct CloseInput {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
};
using CodecContextPtr = std::unique_ptr<AVCodecContext, FreeCodecContext>;
using FramePtr = std::unique_ptr<AVFrame, FreeFrame>;
using PacketPtr = std::unique_ptr<AVPacket, FreePacket>;
using InputPtr = std::unique_ptr<AVFormatContext, CloseInput>;

/// FFmpeg's own words for an error code.
[[nodiscard]] inline std::string error_text(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

/// Keeps FFmpeg from printing; libraries never print.
inline void silence_ffmpeg() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace twang::detail
