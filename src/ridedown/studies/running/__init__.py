"""Where rows are computed: threads or a cluster; and searches, whose rows follow from one another."""
