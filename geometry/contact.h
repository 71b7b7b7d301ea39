// The contact of a dial has moved to its instrument; this name stays for a while.
#pragma once

#include "geometry/instruments/contact.h"
