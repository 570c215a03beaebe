/// Lodestar's version, in its one place. Semantic versioning: until 1.0 a minor step may break the API.
#ifndef LODESTAR_VERSION_H
#define LODESTAR_VERSION_H

#define LODE_VERSION_MAJOR 0
#define LODE_VERSION_MINOR 1
#define LODE_VERSION_PATCH 0

#endif
