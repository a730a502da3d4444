#include "bags/chunk_compression.hpp"

#include "config/errors.hpp"
#ifdef GRIPLINE_BZIP2
#include <bzlib.h>
#endif
#ifdef GRIPLINE_LZ4
#include <lz4frame.h>
#endif

namespace gripline::tools {
namespace {

using Buffer = std::vector<std::byte>;

[[noreturn]] void refuse_chunk(const std::string& compression) {
  throw InputError("a chunk cannot be unpacked (" + compression + ")");
}

#ifdef GRIPLINE_BZIP2
Buffer unpack_bzip2(Buffer packed, std::size_t size) {
  Buffer out(size);
  auto length = static_cast<unsigned>(size);
  const int code =
      BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(out.data()), &length, reinterpret_cast<char*>(packed.data()),
                                 static_cast<unsigned>(packed.size()), 0, 0);
  if (code != BZ_OK || length != size) refuse_chunk("bz2");
  return out;
}
#else
Buffer unpack_bzip2(const Buffer&, std::size_t) { refuse_chunk("bz2"); }
#endif

#ifdef GRIPLINE_LZ4
Buffer unpack_lz4(const Buffer& packed, std::size_t size) {
  Buffer out(size);
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) refuse_chunk("lz4");
  std::size_t read = 0, written = 0, hint = 1;
  while (hint != 0 && read < packed.size()) {
    std::size_t to = size - written, from = packed.size() - read;
    hint = LZ4F_decompress(context, out.data() + written, &to, packed.data() + read, &from, nullptr);
    if (LZ4F_isError(hint) != 0 || (to == 0 && from == 0)) break;
    read += from, written += to;
  }
  LZ4F_freeDecompressionContext(context);
  if (hint != 0 || written != size) refuse_chunk("lz4");
  return out;
}
#else
Buffer unpack_lz4(const Buffer&, std::size_t) { refuse_chunk("lz4"); }
#endif

}  // namespace

std::string missing_for([[maybe_unused]] const std::string& compression) {
#ifndef GRIPLINE_BZIP2
  if (compression == "bz2") return "libbz2-dev";
#endif
#ifndef GRIPLINE_LZ4
  if (compression == "lz4") return "liblz4-dev";
#endif
  return "";
}

std::vector<std::byte> unpack_chunk(const std::string& compression, std::vector<std::byte> packed, std::size_t size) {
  if (compression == "bz2") return unpack_bzip2(std::move(packed), size);
  if (compression == "lz4") return unpack_lz4(packed, size);
  if (compression != "none") throw InputError("a chunk is packed in an unknown way, \"" + compression + "\"");
  if (packed.size() != size) refuse_chunk(compression);
  return packed;
}

}  // namespace gripline::tools
