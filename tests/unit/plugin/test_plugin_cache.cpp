#include "plugin/plugin_cache.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace gripline {
namespace test_plugin_cache {

TEST(PluginCache, IsWhereTheUsersCachesAre) {
  setenv("HOME", "/home/ada", 1);
  setenv("XDG_CACHE_HOME", "/var/caches", 1);
  EXPECT_EQ(plugin_cache_folder(), "/var/caches/gripline");
  for (const char* unset : {"", "caches"}) {
    setenv("XDG_CACHE_HOME", unset, 1);
    EXPECT_EQ(plugin_cache_folder(), "/home/ada/.cache/gripline");
  }
  unsetenv("XDG_CACHE_HOME");
  EXPECT_EQ(plugin_cache_folder(), "/home/ada/.cache/gripline");
  unsetenv("HOME");
  EXPECT_EQ(plugin_cache_folder(), "");
}

}  // namespace test_plugin_cache
}  // namespace gripline
