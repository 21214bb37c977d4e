// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/png.hpp"

#include "capture/detail/ffmpeg.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace twang {
namespace {

using namespace detail;

void check_image(const Image& image) {
  const bool shaped = image.width_px > 0 && image.height_px > 0 &&
                      (image.channels == 1 || image.channels == 3) &&
                      image.pixels.size() == static_cast<std::size_t>(image.width_px) *
                                                 static_cast<std::size_t>(image.height_px) *
                                                 static_cast<std::size_t>(image.channels);
  if (shaped) return;
  throw InputError(
      fmt::format("an image is {} x {} px with {} channels in {} bytes, must be grey or RGB with "
                  "one byte a channel",
                  image.width_px,
                  image.height_px,
                  image.channels,
                  image.pixels.size()));
}

void check_status(int status) {
  if (status < 0) {
    throw InputError(fmt::format("a PNG image cannot be encoded ({})", error_text(status)));
  }
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
  silence_ffmpeg();
  check_image(image);
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_PNG);
  if (!encoder) throw InputError("a PNG image cannot be encoded: FFmpeg was built without PNG");
  const CodecContextPtr codec(avcodec_alloc_context3(encoder));
  codec->width = image.width_px;
  codec->height = image.height_px;
  codec->pix_fmt = image.channels == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_RGB24;
  codec->time_base = {1, 1};
  codec->thread_count = 1;
  check_status(avcodec_open2(codec.get(), encoder, nullptr));

  const FramePtr frame(av_frame_alloc());
  frame->width = image.width_px;
  frame->height = image.height_px;
  frame->format = codec->pix_fmt;
  check_status(av_frame_get_buffer(frame.get(), 0));
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(image.width_px) * image.channels;
  for (int y = 0; y < image.height_px; ++y) {
    std::copy_n(image.pixels.data() + y * row, row, frame->data[0] + y * frame->linesize[0]);
  }

  const PacketPtr packet(av_packet_alloc());
  check_status(avcodec_send_frame(codec.get(), frame.get()));
  check_status(avcodec_receive_packet(codec.get(), packet.get()));
  return {packet->data, packet->data + packet->size};
}

}  // namespace twang
