#include "config/hash.hpp"

#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <array>
#include <stdexcept>

#include "config/files.hpp"

namespace gripline {

std::string sha256_hex(std::string_view bytes) {
  // A user's openssl.cnf may leave out the provider that has SHA-256.
  static const int ready = OPENSSL_init_crypto(OPENSSL_INIT_NO_LOAD_CONFIG, nullptr);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (ready != 1 || EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("OpenSSL cannot compute a SHA-256");
  constexpr std::string_view hex = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += hex[digest[i] >> 4U];
    text += hex[digest[i] & 0xfU];
  }
  return text;
}

std::string sha256_of_file(const std::filesystem::path& file) { return sha256_hex(read_bytes(file)); }

}  // namespace gripline
