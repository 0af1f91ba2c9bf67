/* Vectors of the processor. A function for vectors is compiled for each width; the widest one is chosen when it runs. */

#define BLOCK 8       /* elements processed at a time */
#define MAX_STAGES 17 /* of a step */

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define X86_VECTORS
#include <immintrin.h>
typedef double Values4 __attribute__((vector_size(32)));
typedef double Row4 __attribute__((vector_size(32), aligned(8)));
typedef long long Bits4 __attribute__((vector_size(32)));
typedef double Values8 __attribute__((vector_size(64)));
typedef double Row8 __attribute__((vector_size(64), aligned(8)));
typedef long long Bits8 __attribute__((vector_size(64)));
#endif
