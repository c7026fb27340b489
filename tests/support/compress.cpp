#include "support/compress.h"

#include <zlib.h>
#include <zstd.h>

#include <memory>
#include <stdexcept>

namespace remaps::test {

std::string gzip(std::string_view content) {
  z_stream stream = {};
  constexpr int kGzip = 16;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzip, 8,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("deflateInit2");
  std::string out(deflateBound(&stream, content.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<unsigned>(content.size());
  stream.next_out = reinterpret_cast<unsigned char*>(out.data());
  stream.avail_out = static_cast<unsigned>(out.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("deflate");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string zstd(std::string_view content, bool announce_size, int window_log) {
  const std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(),
                                                                        ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_contentSizeFlag, announce_size ? 1 : 0);
  if (window_log > 0) ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, window_log);
  std::string out(ZSTD_compressBound(content.size()) + 64, '\0');
  if (announce_size) {
    const std::size_t n =
        ZSTD_compress2(context.get(), out.data(), out.size(), content.data(), content.size());
    if (ZSTD_isError(n) != 0) throw std::runtime_error("ZSTD_compress2");
    out.resize(n);
    return out;
  }
  // A stream whose end is not in sight keeps the size out of the header, and the window whole.
  ZSTD_outBuffer to = {out.data(), out.size(), 0};
  ZSTD_inBuffer from = {content.data(), content.size(), 0};
  if (ZSTD_isError(ZSTD_compressStream2(context.get(), &to, &from, ZSTD_e_flush)) != 0)
    throw std::runtime_error("ZSTD_compressStream2");
  while (ZSTD_compressStream2(context.get(), &to, &from, ZSTD_e_end) != 0) {
  }
  out.resize(to.pos);
  return out;
}

}  // namespace remaps::test
