// The one place where the Vulkan loader's entry points live. The loader itself is opened at run time, so that the
// program starts where no Vulkan is installed.
#define VOLK_IMPLEMENTATION
#include <volk.h>
