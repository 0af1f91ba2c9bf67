/* Asks Python whether to stop: at the time limit, if `expired()` is true, or after Ctrl-C. `thread` is the state that was saved
   when the lock was released. */
static int interrupted(PyObject *expired, PyThreadState **thread)
{
    PyObject *answer;
    int stop;
    PyEval_RestoreThread(*thread);
    answer = PyErr_CheckSignals() < 0 ? NULL : PyObject_CallFunctionObjArgs(expired, NULL);
    stop = !answer || PyObject_IsTrue(answer);
    Py_XDECREF(answer);
    *thread = PyEval_SaveThread();
    return stop;
}
