/* What compiled code calls where mypyc would look a function of Python's library up by its name and pass it boxed
   numbers. Each gives what Python gives, to the last digit; what is rare goes to Python's own function. */

#ifndef USV_OPERATIONS_H
#define USV_OPERATIONS_H

#include <Python.h>
#include <math.h>
#include <CPy.h>

/* Where these are called something has gone wrong: such lines stand apart from those of every tick, which so fill less
   of the processor's caches. */
void CPy_AddTraceback(const char *file, const char *function, int line, PyObject *globals) __attribute__((cold));
void CPy_TypeErrorTraceback(const char *file, const char *function, int line, PyObject *globals, const char *expected,
                            PyObject *value) __attribute__((cold));
void CPy_AttributeError(const char *file, const char *function, const char *class_name, const char *attribute, int line,
                        PyObject *globals) __attribute__((cold));
void CPy_TypeError(const char *expected, PyObject *value) __attribute__((cold));
void CPyError_OutOfMemory(void) __attribute__((cold));

#define USV_ERROR (-113.0) /* as mypyc: it then asks whether there is an exception */

/* Python's own function of the module math, of the first `count` numbers. */
static double __attribute__((noinline, unused)) usv_math3(const char *name, double x, double y, double z, int count) {
    PyObject *module = PyImport_ImportModule("math"), *found;
    double value;
    if (module == NULL) return USV_ERROR;
    found = PyObject_CallMethod(module, name, count == 1 ? "d" : count == 2 ? "dd" : "ddd", x, y, z);
    Py_DECREF(module);
    if (found == NULL) return USV_ERROR;
    value = PyFloat_AsDouble(found);
    Py_DECREF(found);
    return value;
}

static inline double usv_math(const char *name, double x, double y, int count) {
    return usv_math3(name, x, y, 0.0, count);
}

/* Error of the product p of a and a (Dekker 1971). */
static inline double usv_square_error(double a, double p) {
    double t = a * 134217729.0, high = t - (t - a), low = a - high;
    return ((high * high - p) + 2.0 * high * low) + low * low;
}

/* The root of a sum, whose rest is `low`. */
static inline double usv_root(double sum, double low) {
    double root = sqrt(sum), square = root * root;
    return root + (((sum - square) - usv_square_error(root, square)) + low) / (2.0 * root);
}

/* The root of the sum of two squares, rounded once, as Python's since 3.10: the sum of the squares and the rest of its
   root in twice the digits. */
static inline double usv_hypot(double x, double y) {
    double a = fabs(x), b = fabs(y), p, q, sum;
    if (a < b) { double t = a; a = b; b = t; }
    if (!(a < 1e140 && b > 1e-140)) return b == 0.0 && a < 1e140 ? a : usv_math("hypot", x, y, 2);
    p = a * a;
    q = b * b;
    sum = p + q;
    return usv_root(sum, ((p - sum) + q) + (usv_square_error(a, p) + usv_square_error(b, q)));
}

static inline double usv_hypot3(double x, double y, double z) {
    double a = fabs(x), b = fabs(y), c = fabs(z), t, p, q, r, first, sum, low;
    if (a < b) { t = a; a = b; b = t; }
    if (a < c) { t = a; a = c; c = t; }
    if (b < c) { t = b; b = c; c = t; }
    if (c == 0.0) return usv_hypot(a, b);
    if (!(a < 1e140 && c > 1e-140)) return usv_math3("hypot", x, y, z, 3);
    p = a * a;
    q = b * b;
    r = c * c;
    first = p + q;
    sum = first + r;
    low = ((p - first) + q) + ((first - sum) + r);
    return usv_root(sum, low + (usv_square_error(a, p) + usv_square_error(b, q) + usv_square_error(c, r)));
}

static inline char usv_isfinite(double x) { return isfinite(x) != 0; }
static inline double usv_radians(double x) { return x * (3.141592653589793 / 180.0); }
static inline double usv_degrees(double x) { return x * (180.0 / 3.141592653589793); }

static inline double usv_fmod(double x, double y) {
    return isfinite(x) && isfinite(y) && y != 0.0 ? fmod(x, y) : usv_math("fmod", x, y, 2);
}

static inline double usv_remainder(double x, double y) {
    return isfinite(x) && isfinite(y) && y != 0.0 ? remainder(x, y) : usv_math("remainder", x, y, 2);
}

static inline double usv_asin(double x) { return fabs(x) <= 1.0 ? asin(x) : usv_math("asin", x, 0.0, 1); }
static inline double usv_acos(double x) { return fabs(x) <= 1.0 ? acos(x) : usv_math("acos", x, 0.0, 1); }
static inline double usv_expm1(double x) { return fabs(x) < 700.0 ? expm1(x) : usv_math("expm1", x, 0.0, 1); }

/* x ** y */
static inline double usv_power(double x, double y) {
    PyObject *a, *b, *power;
    double value = y == 2.0 || x > 0.0 ? pow(x, y) : NAN;
    if (isfinite(value)) return value;
    a = PyFloat_FromDouble(x);
    b = PyFloat_FromDouble(y);
    power = a != NULL && b != NULL ? PyNumber_Power(a, b, Py_None) : NULL;
    Py_XDECREF(a);
    Py_XDECREF(b);
    if (power == NULL) return USV_ERROR;
    value = PyFloat_AsDouble(power); /* a complex number is a TypeError, as where it is used for a float */
    Py_DECREF(power);
    return value;
}

/* The numbers of a flat memoryview of float64; NULL for anything else. */
static inline double *usv_numbers(PyObject *view, CPyTagged at) {
    Py_buffer *buffer;
    if (!PyMemoryView_Check(view) || (at & CPY_INT_TAG) != 0) return NULL;
    buffer = PyMemoryView_GET_BUFFER(view);
    if (buffer->ndim != 1 || buffer->itemsize != 8 || buffer->strides[0] != 8 || buffer->suboffsets != NULL) return NULL;
    if (buffer->format == NULL || buffer->format[0] != 'd' || buffer->format[1] != 0) return NULL;
    return (size_t)at < (size_t)buffer->shape[0] * 2 ? (double *)buffer->buf : NULL;
}

/* view[at] = x */
static inline int usv_set_number(PyObject *view, CPyTagged at, double x) {
    double *numbers = usv_numbers(view, at);
    PyObject *index, *number;
    int done;
    if (numbers != NULL && !PyMemoryView_GET_BUFFER(view)->readonly) {
        numbers[at / 2] = x;
        return 0;
    }
    index = CPyTagged_AsObject(at);
    number = PyFloat_FromDouble(x);
    done = number == NULL ? -1 : PyObject_SetItem(view, index, number);
    Py_XDECREF(number);
    Py_DECREF(index);
    return done;
}

/* view[at] */
static inline PyObject *usv_get_item(PyObject *view, CPyTagged at) {
    double *numbers = usv_numbers(view, at);
    PyObject *index, *found;
    if (numbers != NULL) return PyFloat_FromDouble(numbers[at / 2]);
    index = CPyTagged_AsObject(at);
    found = PyObject_GetItem(view, index);
    Py_DECREF(index);
    return found;
}

/* sum(data) of bytes */
static inline PyObject *usv_sum_bytes(PyObject *data) {
    const unsigned char *at = (const unsigned char *)PyBytes_AS_STRING(data), *end = at + PyBytes_GET_SIZE(data);
    unsigned long sum = 0;
    while (at < end) sum += *at++;
    return PyLong_FromUnsignedLong(sum);
}

/* round(x) */
static inline CPyTagged usv_round(double x) {
    PyObject *whole;
    if (fabs(x) < 4e18) return (CPyTagged)((Py_ssize_t)nearbyint(x) * 2);
    whole = PyLong_FromDouble(x);
    return whole == NULL ? CPY_INT_TAG : CPyTagged_StealFromObject(whole);
}

static const int64_t usv_tens[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000, 1000000000, 10000000000,
                                   100000000000};

/* |x| times a power of ten as a whole number, rounded once, half to even, by whole numbers alone: what Python's own
   formats find with numbers of any length. -1 where it is too large for that. */
static inline int64_t usv_scaled(double x, int decimals) {
#ifdef __SIZEOF_INT128__
    uint64_t bits, whole;
    unsigned __int128 product, rest, half;
    int exponent;
    if (!(fabs(x) < 8e9)) return -1;
    memcpy(&bits, &x, 8);
    exponent = (int)(bits >> 52 & 0x7FF);
    if (exponent == 0) return bits << 1 == 0 ? 0 : -1;
    product = (unsigned __int128)(bits << 12 >> 12 | 1ULL << 52) * (uint64_t)usv_tens[decimals];
    exponent = 1075 - exponent; /* bits behind the point, 20 or more */
    if (exponent > 100) return 0;
    half = (unsigned __int128)1 << (exponent - 1);
    rest = product & ((half << 1) - 1);
    whole = (uint64_t)(product >> exponent);
    return (int64_t)(whole + (rest > half || (rest == half && (whole & 1))));
#else
    return -1;
#endif
}

/* format(x, ".Nf"); NULL without an error where it has to go the long way */
static PyObject *__attribute__((noinline, unused)) usv_fixed(double x, int decimals) {
    int64_t whole = usv_scaled(x, decimals);
    char digits[40], *at = digits + sizeof digits;
    int count = 0;
    if (whole < 0) return NULL;
    for (; whole != 0 || count <= decimals; whole /= 10) {
        *--at = (char)('0' + whole % 10);
        if (++count == decimals) *--at = '.';
    }
    if (signbit(x)) *--at = '-';
    return PyUnicode_DecodeASCII(at, digits + sizeof digits - at, NULL);
}

/* The number of seven digits that is nearest to a float32: float(format(x, ".7g")). False where it has to go the long
   way. */
static inline int usv_seven_digits(double x, double *to) {
    int decimals = 6;
    int64_t whole;
    double size = fabs(x);
    if (x == 0.0) {
        *to = x;
        return 1;
    }
    if (!(size >= 1e-4 && size < 1e6)) return 0;
    while (size >= 1e7 / (double)usv_tens[decimals]) decimals--;
    while (size < 1e6 / (double)usv_tens[decimals]) decimals++;
    if ((whole = usv_scaled(x, decimals)) < 0) return 0;
    *to = copysign((double)whole / (double)usv_tens[decimals], x); /* of two numbers without an error: rounded once */
    return 1;
}

/* format(x, text), quick for a text like ".3f" */
static inline PyObject *usv_format_float(double x, PyObject *text) {
    PyObject *number, *done;
    if (PyUnicode_GET_LENGTH(text) == 3 && PyUnicode_IS_ASCII(text)) {
        const Py_UCS1 *at = PyUnicode_1BYTE_DATA(text);
        if (at[0] == '.' && at[1] >= '1' && at[1] <= '9' && (at[2] == 'f' || at[2] == 'g')) {
            if (at[2] == 'f' && (done = usv_fixed(x, at[1] - '0')) != NULL) return done;
            char *digits = PyOS_double_to_string(x, (char)at[2], at[1] - '0', 0, NULL);
            if (digits == NULL) return NULL;
            done = PyUnicode_FromString(digits);
            PyMem_Free(digits);
            return done;
        }
    }
    if ((number = PyFloat_FromDouble(x)) == NULL) return NULL;
    done = PyObject_Format(number, text);
    Py_DECREF(number);
    return done;
}

/* format(x, text) of a whole number, quick for a text like "02d" */
static inline PyObject *usv_format_int(CPyTagged x, PyObject *text) {
    PyObject *number, *done;
    if ((x & CPY_INT_TAG) == 0 && (Py_ssize_t)x >= 0 && PyUnicode_IS_ASCII(text) && PyUnicode_GET_LENGTH(text) == 3) {
        const Py_UCS1 *at = PyUnicode_1BYTE_DATA(text);
        if (at[0] == '0' && at[1] >= '1' && at[1] <= '9' && (at[2] == 'd' || at[2] == 'X')) {
            char digits[32], *first = digits + sizeof digits, *least = first - (at[1] - '0');
            size_t rest = x / 2, base = at[2] == 'd' ? 10 : 16;
            for (; rest != 0 || first > least; rest /= base) *--first = "0123456789ABCDEF"[rest % base];
            return PyUnicode_FromStringAndSize(first, digits + sizeof digits - first);
        }
    }
    if ((number = CPyTagged_AsObject(x)) == NULL) return NULL;
    done = PyObject_Format(number, text);
    Py_DECREF(number);
    return done;
}

/* One value of a column in the form of `companion.record.columns`. Returns its bytes, 0 where the form does not give it
   back exactly, -1 for an error. */
static int __attribute__((noinline, unused)) usv_narrow(char form, PyObject *value, double tick_us, char *to) {
    double x, back;
    float narrow;
    int32_t age;
    int64_t whole;
    if (form == 'q') {
        if (value == Py_None || (PyFloat_CheckExact(value) && isnan(PyFloat_AS_DOUBLE(value)))) {
            whole = INT64_MIN;
        } else {
            whole = PyLong_AsLongLong(value);
            if (whole == -1 && PyErr_Occurred()) {
                PyErr_Clear();
                return 0;
            }
        }
        memcpy(to, &whole, 8);
        return 8;
    }
    x = PyFloat_CheckExact(value) ? PyFloat_AS_DOUBLE(value) : value == Py_None ? Py_NAN : PyFloat_AsDouble(value);
    if (x == -1.0 && PyErr_Occurred()) return -1;
    if (form == 'd') {
        memcpy(to, &x, 8);
        return 8;
    }
    if (form == 'u') {
        back = tick_us - nearbyint(x * 1e6);
        if (!(fabs(back) < 2147483648.0)) return 0;
        age = (int32_t)back;
        memcpy(to, &age, 4);
        return (tick_us - back) / 1e6 == x ? 4 : 0;
    }
    narrow = (float)x;
    memcpy(to, &narrow, 4);
    back = narrow;
    if (form == 's' && isfinite(back) && !usv_seven_digits(back, &back)) {
        char *digits = PyOS_double_to_string(back, 'g', 7, 0, NULL);
        if (digits == NULL) return -1;
        back = PyOS_string_to_double(digits, NULL, NULL);
        PyMem_Free(digits);
    }
    return memcmp(&back, &x, 8) == 0 ? 4 : 0;
}

/* `companion.record.columns.narrowed` */
static PyObject *__attribute__((noinline, unused)) usv_narrowed(PyObject *packer, PyObject *rows, CPyTagged tick_us) {
    static PyObject *heads_name, *forms_name;
    PyObject *heads, *forms, *data = NULL, *row;
    Py_ssize_t count = PyList_GET_SIZE(rows), column, at, size = 0;
    char *to, *begin;
    int done = 1;
    if (heads_name == NULL) {
        heads_name = PyUnicode_InternFromString("heads");
        forms_name = PyUnicode_InternFromString("forms");
        if (heads_name == NULL || forms_name == NULL) return NULL;
    }
    heads = PyObject_GetAttr(packer, heads_name);
    forms = PyObject_GetAttr(packer, forms_name);
    if (heads == NULL || forms == NULL) goto end;
    for (column = 0; column < PyTuple_GET_SIZE(heads); column++) size += PyBytes_GET_SIZE(PyTuple_GET_ITEM(heads, column));
    data = PyBytes_FromStringAndSize(NULL, size + 8 * count * PyUnicode_GET_LENGTH(forms));
    if (data == NULL) goto end;
    begin = to = PyBytes_AS_STRING(data);
    for (column = 0; column < PyTuple_GET_SIZE(heads) && done > 0; column++) {
        PyObject *head = PyTuple_GET_ITEM(heads, column);
        memcpy(to, PyBytes_AS_STRING(head), PyBytes_GET_SIZE(head));
        to += PyBytes_GET_SIZE(head);
        for (at = 0; column > 0 && at < count && done > 0; at++) {
            row = PyList_GET_ITEM(rows, at);
            row = PyTuple_CheckExact(row) ? PyTuple_GET_ITEM(row, column - 1) : PyList_GET_ITEM(row, column - 1);
            done = usv_narrow((char)PyUnicode_1BYTE_DATA(forms)[column - 1], row, (double)((Py_ssize_t)tick_us / 2), to);
            to += done;
        }
    }
    if (done < 0) Py_CLEAR(data);
    else if (done == 0) Py_SETREF(data, Py_NewRef(Py_None));
    else _PyBytes_Resize(&data, to - begin);
end:
    Py_XDECREF(heads);
    Py_XDECREF(forms);
    return data;
}

/* The numbers of a flat memoryview of float64 that has `count` of them, or any number for -1; else NULL, with an error. */
static inline double *usv_all_numbers(PyObject *view, Py_ssize_t count) {
    double *numbers = usv_numbers(view, 0);
    if (numbers != NULL && (count < 0 || PyMemoryView_GET_BUFFER(view)->shape[0] == count)) return numbers;
    PyErr_SetString(PyExc_TypeError, "not a flat memoryview of so many float64");
    return NULL;
}

/* `companion.nav.matrix_in_place.add_to_diagonal` */
static inline char usv_add_to_diagonal(PyObject *diagonal, PyObject *added, PyObject *matrix_flat, PyObject *added_flat) {
    double *to, *from = usv_all_numbers(added_flat, -1);
    Py_ssize_t count = from == NULL ? 0 : PyMemoryView_GET_BUFFER(added_flat)->shape[0], at;
    if (from == NULL || (to = usv_all_numbers(matrix_flat, count * count)) == NULL) return 2;
    for (at = 0; at < count; at++) to[at * (count + 1)] += from[at];
    return 1;
}

/* `companion.nav.matrix_in_place.subtract` */
static inline char usv_subtract(PyObject *matrix, PyObject *other, PyObject *matrix_flat, PyObject *other_flat) {
    double *to, *from = usv_all_numbers(other_flat, -1);
    Py_ssize_t count = from == NULL ? 0 : PyMemoryView_GET_BUFFER(other_flat)->shape[0], at;
    if (from == NULL || (to = usv_all_numbers(matrix_flat, count)) == NULL) return 2;
    for (at = 0; at < count; at++) to[at] -= from[at];
    return 1;
}

/* `companion.nav.matrix_in_place.symmetrise` */
static inline char usv_symmetrise(PyObject *matrix, PyObject *transposed, PyObject *work, PyObject *matrix_flat) {
    double *p = usv_all_numbers(matrix_flat, -1);
    Py_ssize_t count = 0, row, column;
    if (p == NULL) return 2;
    while (count * count < PyMemoryView_GET_BUFFER(matrix_flat)->shape[0]) count++;
    for (row = 1; row < count; row++)
        for (column = 0; column < row; column++)
            p[row * count + column] = p[column * count + row] = 0.5 * (p[row * count + column] + p[column * count + row]);
    return 1;
}

/* The exclusive or of all bytes. */
static inline CPyTagged usv_checksum(PyObject *data) {
    const unsigned char *at = (const unsigned char *)PyBytes_AS_STRING(data), *end = at + PyBytes_GET_SIZE(data);
    unsigned char all = 0;
    while (at < end) all ^= *at++;
    return (CPyTagged)all * 2;
}

#endif
