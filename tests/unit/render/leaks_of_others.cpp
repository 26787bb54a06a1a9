// Under a leak checker: what Vulkan's validation layer keeps for itself when its instance goes is not ours.

extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libVkLayer_khronos_validation\n";
}
