// The studio's settings: whatever the file holds leaves a state that is written and read back as itself.
#include "ui3d/studio/files/settings.h"

#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  studio::StudioState state;
  (void)studio::applySettings({reinterpret_cast<const char*>(data), size}, state);
  const std::string text = studio::settingsText(state);
  studio::StudioState again;
  tests::require(studio::applySettings(text, again) && studio::settingsText(again) == text);
  return 0;
}
